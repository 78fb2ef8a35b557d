/** One scope: a uPlot that is fed from a source once a frame, when there is something new. */

import uPlot from 'uplot';
import { minus, scaleFor } from '../units';
import { writeCurve, writeTimes, type Points } from './bins';
import type { Scope, Trace } from './catalog';
import type { Palette } from './palette';
import { calmRange, multiples, roundStep, type Range } from './range';
import type { Source } from './source';

/** Room for the numbers of the value axis and of the time axis, CSS pixels. */
const GUTTER = 66;
const AXIS = 22;
const MARKS_ACROSS = 8;
/** A curve that goes up and down this many times its width is dense. */
const DENSE = 6;

/** A moment worth a line on the time axis: a change of parameters, a push. */
export interface Moment {
  time: number;
  label: string;
}

export interface ChartState {
  range: Range;
  /** Whether the value axis follows the data. */
  follow: boolean;
  moments: readonly Moment[];
  /** Time of the mark that values are compared with. */
  mark: number | null;
}

export interface ChartEvents {
  zoom(range: Range): void;
  reset(): void;
  mark(time: number): void;
  /** Time under the pointer; null when it leaves. */
  cursor(time: number | null): void;
}

export class Chart {
  private plot: uPlot;
  private readonly data: Points[];
  private minimum = new Float32Array(0);
  private maximum = new Float32Array(0);
  private values: Range | null = null;
  private drawn = '';
  private state: ChartState | null = null;
  private source: Source | null = null;
  private empty = true;
  private readonly family: string;

  constructor(
    private readonly element: HTMLElement,
    private readonly scope: Scope,
    private readonly palette: Palette,
    private readonly events: ChartEvents,
    /** Whether the labels of moments stand in this scope, and the time axis under it. */
    private readonly first: boolean,
    private readonly last: boolean,
  ) {
    this.family = getComputedStyle(element).fontFamily;
    this.data = [[], ...scope.traces.map((): Points => [])];
    this.plot = new uPlot(this.options(), this.data as uPlot.AlignedData, element);
  }

  destroy(): void {
    this.plot.destroy();
  }

  resize(): void {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (width > 0 && height > 0) this.plot.setSize({ width, height });
    this.drawn = '';
  }

  /** Draws, unless nothing has changed since the last time. */
  draw(source: Source, state: ChartState): void {
    const { range, follow, moments, mark } = state;
    const key = `${source.version} ${range.from} ${range.to} ${follow} ${moments.length} ${mark}`;
    if (key === this.drawn) return;
    this.drawn = key;
    this.state = state;
    this.source = source;
    const [low, high] = this.fill(source, range);
    this.empty = !(low <= high);
    if (follow || !this.values) this.values = calmRange(follow ? this.values : null, low, high);
    const values = this.values;
    const { plot } = this;
    plot.batch(() => {
      plot.setData(this.data as uPlot.AlignedData, false);
      plot.setScale('x', { min: range.from, max: range.to });
      plot.setScale('y', { min: values.from, max: values.to });
    });
  }

  /** Fits the value axis to what is visible. */
  autoscale(): void {
    this.values = null;
    this.drawn = '';
  }

  private fill(source: Source, range: Range): [number, number] {
    const bins = source.cut(
      range.from,
      range.to,
      Math.max(50, this.plot.bbox.width / devicePixelRatio),
    );
    if (this.minimum.length < bins.count) {
      this.minimum = new Float32Array(bins.count + 64);
      this.maximum = new Float32Array(bins.count + 64);
    }
    const { minimum, maximum } = this;
    writeTimes(bins, source.start, source.step, this.data[0] as number[]);
    let low = Number.POSITIVE_INFINITY;
    let high = Number.NEGATIVE_INFINITY;
    this.scope.traces.forEach((trace, i) => {
      source.reduce(trace.column, bins, minimum, maximum);
      writeCurve(bins, minimum, maximum, this.data[i + 1] as Points);
      for (let bin = 0; bin < bins.count; bin++) {
        if ((minimum[bin] as number) < low) low = minimum[bin] as number;
        if ((maximum[bin] as number) > high) high = maximum[bin] as number;
      }
    });
    return [low, high];
  }

  private options(): uPlot.Options {
    const { palette, scope } = this;
    const grid = { stroke: palette.grid, width: 1 };
    const font = `11px ${this.family}`;
    const shared = { stroke: palette.axis, font, ticks: { show: false }, grid };
    return {
      width: Math.max(1, this.element.clientWidth),
      height: Math.max(1, this.element.clientHeight),
      padding: [6, 18, this.last ? 0 : 6, 0],
      legend: { show: false },
      focus: { alpha: 1 },
      scales: { x: { time: false, auto: false }, y: { auto: false } },
      series: [{}, ...scope.traces.map((trace) => this.series(trace))],
      axes: [
        {
          ...shared,
          size: this.last ? AXIS : 0,
          gap: 5,
          space: 70,
          values: (_, splits) =>
            this.last
              ? splits.map((split, i) => `${split}${i === splits.length - 1 ? ' s' : ''}`)
              : [],
        },
        {
          ...shared,
          size: GUTTER,
          gap: 6,
          splits: (plot) => this.valueSplits(plot),
          values: (_, splits) => this.valueTexts(splits),
        },
      ],
      cursor: {
        sync: { key: 'lab', setSeries: false, scales: ['x', null] },
        y: false,
        drag: { x: true, y: false, setScale: false, dist: 4 },
        points: { size: 5, width: 1 },
        bind: {
          dblclick: () => () => {
            this.events.reset();
            return null;
          },
        },
      },
      hooks: {
        setSelect: [(plot) => this.selected(plot)],
        setCursor: [(plot) => this.pointed(plot)],
        drawAxes: [(plot) => this.drawMoments(plot)],
        draw: [
          (plot) => {
            this.drawCurves(plot);
            this.drawMarkers(plot);
          },
        ],
        ready: [
          (plot) => {
            plot.over.addEventListener('click', () => {
              const { left } = plot.cursor;
              if (plot.select.width < 4 && left !== undefined && left >= 0) {
                this.events.mark(plot.posToVal(left, 'x'));
              }
            });
          },
        ],
      },
    };
  }

  private series(trace: Trace): uPlot.Series {
    return {
      stroke: this.palette[trace.ink],
      width: trace.width ?? 1.5,
      points: { show: false },
      // Drawn by drawCurves.
      paths: () => null,
      ...(trace.dash ? { dash: trace.dash } : {}),
    };
  }

  private valueSplits(plot: uPlot): number[] {
    if (this.empty) return [];
    const { min = -1, max = 1 } = plot.scales.y ?? {};
    const lines = plot.bbox.height / devicePixelRatio / 24;
    // Little room: the ends, which are round, and zero.
    const apart = 0.25 * (max - min);
    const splits = multiples({ from: min, to: max }, roundStep((max - min) / Math.min(6, lines)));
    if (lines >= 2.5 && splits.length > 2) return splits;
    return -min > apart && max > apart ? [min, 0, max] : [min, max];
  }

  private valueTexts(splits: number[]): string[] {
    const largest = Math.max(...splits.map(Math.abs));
    const { factor, unit } = scaleFor(largest, this.scope.unit);
    const step = Math.min(...splits.slice(1).map((split, i) => split - (splits[i] ?? 0))) * factor;
    // So many places as tell neighbours apart, and a half where the step has one.
    const places = Number.isFinite(step) ? Math.max(0, Math.ceil(-Math.log10(step / 1.01))) : 0;
    return splits.map((split, i) => {
      const text = minus(String(Number((split * factor).toFixed(places + 1))));
      return i === splits.length - 1 ? `${text} ${unit}` : text;
    });
  }

  private selected(plot: uPlot): void {
    const { left, width } = plot.select;
    if (width < 4) return;
    const range = { from: plot.posToVal(left, 'x'), to: plot.posToVal(left + width, 'x') };
    plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.events.zoom(range);
  }

  private pointed(plot: uPlot): void {
    // Only the plot under the pointer has an event; the others follow by synchronisation.
    if (!plot.cursor.event) return;
    const { left } = plot.cursor;
    this.events.cursor(left === undefined || left < 0 ? null : plot.posToVal(left, 'x'));
  }

  /**
   * Draws the curves itself: with bevelled joins, and without dashes where a curve is so dense that
   * they could not be seen, which takes a third of the time.
   */
  private drawCurves(plot: uPlot): void {
    const { ctx, bbox } = plot;
    const { min = 0, max = 1 } = plot.scales.x ?? {};
    const { min: bottom = 0, max: top = 1 } = plot.scales.y ?? {};
    const perSecond = bbox.width / (max - min);
    const perUnit = bbox.height / (top - bottom);
    const times = this.data[0] as number[];
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.lineJoin = 'bevel';
    this.scope.traces.forEach((trace, i) => {
      const values = this.data[i + 1] as Points;
      let pen = false;
      let travelled = 0;
      let before = 0;
      ctx.beginPath();
      for (let k = 0; k < values.length; k++) {
        const value = values[k] ?? null;
        if (value === null) {
          pen = false;
          continue;
        }
        const x = bbox.left + ((times[k] as number) - min) * perSecond;
        const y = bbox.top + (top - value) * perUnit;
        if (pen) {
          ctx.lineTo(x, y);
          travelled += Math.abs(y - before);
        } else {
          ctx.moveTo(x, y);
          pen = true;
        }
        before = y;
      }
      const dense = travelled > DENSE * bbox.width;
      const width = dense ? 1 : (trace.width ?? 1.5);
      ctx.strokeStyle = this.palette[trace.ink];
      ctx.lineWidth = width * devicePixelRatio;
      ctx.setLineDash(dense ? [] : (trace.dash ?? []).map((part) => part * devicePixelRatio));
      ctx.stroke();
    });
    ctx.restore();
  }

  private drawMoments(plot: uPlot): void {
    const { state } = this;
    if (!state) return;
    const { ctx } = plot;
    const { top, height } = plot.bbox;
    ctx.save();
    ctx.lineWidth = devicePixelRatio;
    ctx.strokeStyle = this.palette.axis;
    const line = (time: number, dash: number[]) => {
      if (time < state.range.from || time > state.range.to) return;
      const x = Math.round(plot.valToPos(time, 'x', true)) + 0.5;
      ctx.setLineDash(dash.map((length) => length * devicePixelRatio));
      ctx.beginPath();
      ctx.moveTo(x, top);
      ctx.lineTo(x, top + height);
      ctx.stroke();
    };
    for (const { time } of state.moments) line(time, [2, 3]);
    if (this.first) this.drawLabels(plot, state);
    if (state.mark !== null) line(state.mark, []);
    ctx.restore();
  }

  /** What happened at the moments, as far as there is room. */
  private drawLabels(plot: uPlot, { moments, range }: ChartState): void {
    const { ctx } = plot;
    ctx.font = `${10 * devicePixelRatio}px ${this.family}`;
    ctx.fillStyle = this.palette.axis;
    ctx.textBaseline = 'top';
    ctx.textAlign = 'left';
    let free = Number.NEGATIVE_INFINITY;
    for (const { time, label } of moments) {
      const x = plot.valToPos(time, 'x', true) + 3 * devicePixelRatio;
      if (time < range.from || time > range.to || x < free) continue;
      ctx.fillText(label, x, plot.bbox.top);
      free = x + ctx.measureText(label).width + 6 * devicePixelRatio;
    }
  }

  /** Round markers at round times: they move along with the curve. */
  private drawMarkers(plot: uPlot): void {
    const { state, source } = this;
    if (!state || !source) return;
    const { ctx } = plot;
    const times = multiples(
      state.range,
      roundStep((state.range.to - state.range.from) / MARKS_ACROSS),
    );
    for (const trace of this.scope.traces) {
      if (trace.marked !== true) continue;
      ctx.fillStyle = this.palette[trace.ink];
      for (const time of times) {
        const value = source.at(trace.column, time);
        if (!Number.isFinite(value)) continue;
        ctx.beginPath();
        ctx.arc(
          plot.valToPos(time, 'x', true),
          plot.valToPos(value, 'y', true),
          3 * devicePixelRatio,
          0,
          2 * Math.PI,
        );
        ctx.fill();
      }
    }
  }
}
