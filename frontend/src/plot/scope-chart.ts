/** One scope: a canvas that is fed from a source once a frame, when there is something new. */

import { scaleFor, type Scale } from '../ui/units';
import { pointsOf, writeCurve, type Bins } from './bins';
import { Canvas, crisp, type Box } from './canvas';
import { ChartPointer, type ChartEvents, type TimeAxis } from './chart-pointer';
import type { Ink, Palette } from './palette';
import { drawQuantileBand, bandExtremes, type QuantileBand } from './quantile-band';
import { calmRange, multiples, roundStep, type Range } from './range';
import type { Source } from './source';
import { timeSplits, valueSplits, valueTexts } from './ticks';

/** Room for the numbers of the value axis and of the time axis, CSS pixels. */
const GUTTER = 66;
const AXIS = 22;
const EDGE = 6;
const RIGHT = 18;
const MARKS_ACROSS = 8;
/** A curve that goes up and down this many times its width is dense. */
const DENSE = 6;

export interface Trace {
  column: string;
  label: string;
  ink: Ink;
  /** Lengths of dash and gap, CSS pixels; solid when left out. */
  dash?: number[];
  /** Round markers along the line: what tells B from A without colour. */
  marked?: boolean;
  width?: number;
}

/** What a chart draws over time. */
export interface Traces {
  unit: string;
  traces: Trace[];
  /** Span of the value axis while all is zero. */
  still?: number;
}

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
  /** Times of the cursors that were set. */
  cursors: readonly number[];
  /** Time under the pointer of any scope, and what its drag has marked. */
  hover: number | null;
  selection: Range | null;
  /** Bands behind the curves. */
  quantileBands: readonly QuantileBand[];
}

interface Line {
  trace: Trace;
  values: Float32Array;
}

export class ScopeChart implements TimeAxis {
  range: Range = { from: 0, to: 1 };
  cursors: readonly number[] = [];
  private readonly canvas: Canvas;
  private readonly c: CanvasRenderingContext2D;
  private readonly pointer: ChartPointer;
  private readonly lines: Line[];
  private bins: Bins = { first: 0, size: 1, count: 0, paired: false };
  private minimum = new Float32Array(0);
  private maximum = new Float32Array(0);
  private values: Range | null = null;
  private quantileBands: readonly QuantileBand[] = [];
  private drawn = '';
  private empty = true;

  constructor(
    element: HTMLCanvasElement,
    private readonly scope: Traces,
    private readonly palette: Palette,
    events: ChartEvents,
    /** Whether the labels of moments stand in this scope, and the time axis under it. */
    private readonly first: boolean,
    private readonly last: boolean,
  ) {
    this.canvas = new Canvas(element, palette);
    this.c = this.canvas.c;
    this.lines = scope.traces.map((trace) => ({ trace, values: new Float32Array(0) }));
    this.pointer = new ChartPointer(element, this, events);
    this.resize();
  }

  destroy(): void {
    this.pointer.destroy();
  }

  resize(): void {
    const { element } = this.canvas;
    this.canvas.resize(element.clientWidth, element.clientHeight);
    this.drawn = '';
  }

  /** Draws, unless nothing has changed since the last time. */
  draw(source: Source, state: ChartState): void {
    const { range, follow, moments, cursors, hover, selection, quantileBands } = state;
    if (quantileBands !== this.quantileBands) this.drawn = '';
    this.quantileBands = quantileBands;
    const key = `${source.version} ${range.from} ${range.to} ${follow} ${moments.length} ${cursors.join()} ${hover} ${selection?.from} ${selection?.to}`;
    if (key === this.drawn) return;
    this.drawn = key;
    this.range = range;
    this.cursors = cursors;
    const [low, high] = this.fill(source);
    this.empty = !(low <= high);
    if (follow || !this.values)
      this.values = calmRange(follow ? this.values : null, low, high, this.scope.still);
    const { values } = this;
    this.canvas.clear();
    this.axes(values);
    this.moments(state);
    this.canvas.clipped(this.box, () => {
      this.bands(values);
      this.c.lineJoin = 'bevel';
      for (const line of this.lines) this.curve(source, line, values);
    });
    this.markers(source, values);
    this.readings(source, values, state);
  }

  /** The unit of the value axis, which readings share. */
  get scale(): Scale {
    const { from, to } = this.values ?? { from: 0, to: 0 };
    return scaleFor(Math.max(-from, to), this.scope.unit);
  }

  get ends(): readonly [number, number] {
    return [GUTTER, GUTTER + this.across];
  }

  private get box(): Box {
    return { left: GUTTER, right: GUTTER + this.across, top: EDGE, bottom: this.bottom };
  }

  private get across(): number {
    return Math.max(1, this.canvas.width - GUTTER - RIGHT);
  }

  private get bottom(): number {
    return this.canvas.height - (this.last ? AXIS : EDGE);
  }

  private px(time: number): number {
    return GUTTER + ((time - this.range.from) / (this.range.to - this.range.from)) * this.across;
  }

  private py(value: number, { from, to }: Range): number {
    return EDGE + ((to - value) / (to - from)) * (this.bottom - EDGE);
  }

  /** Reads what the window holds; returns its least and largest value. */
  private fill(source: Source): [number, number] {
    const bins = source.cut(this.range.from, this.range.to, Math.max(50, this.across));
    this.bins = bins;
    if (this.minimum.length < bins.count) {
      this.minimum = new Float32Array(bins.count + 64);
      this.maximum = new Float32Array(bins.count + 64);
    }
    const { minimum, maximum } = this;
    let low = Number.POSITIVE_INFINITY;
    let high = Number.NEGATIVE_INFINITY;
    for (const line of this.lines) {
      source.reduce(line.trace.column, bins, minimum, maximum);
      if (line.values.length < pointsOf(bins)) line.values = new Float32Array(pointsOf(bins) + 128);
      writeCurve(bins, minimum, maximum, line.values);
      for (let bin = 0; bin < bins.count; bin++) {
        if ((minimum[bin] as number) < low) low = minimum[bin] as number;
        if ((maximum[bin] as number) > high) high = maximum[bin] as number;
      }
    }
    for (const ribbon of this.quantileBands) {
      const [least, most] = bandExtremes(ribbon, this.range);
      low = Math.min(low, least);
      high = Math.max(high, most);
    }
    return [low, high];
  }

  private bands(values: Range): void {
    const { c } = this;
    const x = (time: number) => this.px(time);
    const y = (value: number) => this.py(value, values);
    for (const band of this.quantileBands) drawQuantileBand(c, band, this.palette[band.ink], x, y);
  }

  private axes(values: Range): void {
    const { c, palette, bottom } = this;
    c.strokeStyle = palette.grid;
    c.fillStyle = palette.axis;
    this.canvas.font();
    c.lineWidth = 1;
    c.setLineDash([]);
    c.beginPath();
    c.textAlign = 'center';
    c.textBaseline = 'top';
    const times = timeSplits(this.range, this.across);
    times.forEach((time, i) => {
      const x = crisp(this.px(time));
      c.moveTo(x, EDGE);
      c.lineTo(x, bottom);
      if (this.last) c.fillText(`${time}${i === times.length - 1 ? ' s' : ''}`, x, bottom + 5);
    });
    c.textAlign = 'right';
    c.textBaseline = 'middle';
    const splits = this.empty ? [] : valueSplits(values, bottom - EDGE);
    const texts = valueTexts(splits, this.scope.unit);
    splits.forEach((split, i) => {
      const y = crisp(this.py(split, values));
      c.moveTo(GUTTER, y);
      c.lineTo(this.canvas.width - RIGHT, y);
      c.fillText(texts[i] as string, GUTTER - 6, y);
    });
    c.stroke();
  }

  /** Lines at moments and cursors, and what happened then, as far as there is room. */
  private moments({ moments, cursors, range }: ChartState): void {
    const shown = moments.filter(({ time }) => time >= range.from && time <= range.to);
    for (const { time } of shown) this.upright(time, 'axis', [2, 3]);
    const { c } = this;
    this.canvas.font(10);
    c.textBaseline = 'bottom';
    cursors.forEach((time, i) => {
      if (time < range.from || time > range.to) return;
      this.upright(time, 'strong', i === 0 ? [] : [6, 3]);
      c.textAlign = this.px(time) > this.canvas.width / 2 ? 'right' : 'left';
      const aside = c.textAlign === 'left' ? 3 : -3;
      if (this.last) c.fillText(String(i + 1), this.px(time) + aside, this.bottom);
    });
    if (!this.first) return;
    c.textBaseline = 'top';
    c.textAlign = 'left';
    let free = Number.NEGATIVE_INFINITY;
    for (const { time, label } of shown) {
      const x = this.px(time) + 3;
      if (x < free) continue;
      c.fillText(label, x, EDGE);
      free = x + c.measureText(label).width + 6;
    }
  }

  private upright(time: number, ink: Ink, dash: number[]): void {
    const x = crisp(this.px(time));
    this.c.lineWidth = 1;
    this.c.setLineDash(dash);
    this.canvas.line([x, EDGE], [x, this.bottom], this.palette[ink]);
  }

  /** Without dashes where a curve is so dense that they could not be seen: a third of the time. */
  private curve(source: Source, { trace, values }: Line, { from, to }: Range): void {
    const { c, bins } = this;
    const points = pointsOf(bins);
    const start = this.px(source.start + bins.first * source.step);
    const apart =
      (this.px(source.start + (bins.first + bins.size) * source.step) - start) /
      (points / bins.count);
    const perUnit = (this.bottom - EDGE) / (to - from);
    const top = EDGE + to * perUnit;
    let pen = false;
    let travelled = 0;
    let before = 0;
    c.beginPath();
    for (let k = 0; k < points; k++) {
      const y = top - (values[k] as number) * perUnit;
      if (y !== y) {
        pen = false;
        continue;
      }
      const x = start + k * apart;
      if (pen) {
        c.lineTo(x, y);
        travelled += Math.abs(y - before);
      } else {
        c.moveTo(x, y);
        pen = true;
      }
      before = y;
    }
    const dense = travelled > DENSE * this.across;
    // Where its dashes leave nothing of them to be seen, it goes below the two that it compares.
    const below = dense && trace.ink === 'difference';
    c.globalCompositeOperation = below ? 'destination-over' : 'source-over';
    c.strokeStyle = this.palette[trace.ink];
    c.lineWidth = dense ? 1 : (trace.width ?? 1.5);
    c.setLineDash(dense ? [] : (trace.dash ?? []));
    c.stroke();
  }

  /** Round markers at round times: they move along with the curve. */
  private markers(source: Source, values: Range): void {
    const { from, to } = this.range;
    const times = multiples(this.range, roundStep((to - from) / MARKS_ACROSS));
    for (const { trace } of this.lines) {
      if (trace.marked !== true) continue;
      for (const time of times) this.dot(source, trace, time, values, 3);
    }
  }

  private dot(source: Source, { column, ink }: Trace, time: number, values: Range, radius: number) {
    const value = source.at(column, time);
    if (!Number.isFinite(value)) return;
    this.canvas.dot(this.px(time), this.py(value, values), radius, this.palette[ink]);
  }

  /** The line under the pointer, the values there, and what a drag marks. */
  private readings(source: Source, values: Range, { hover, cursors, selection }: ChartState): void {
    for (const { trace } of this.lines) {
      for (const time of cursors) this.dot(source, trace, time, values, 2.5);
    }
    if (hover === null) return;
    this.upright(hover, 'strong', []);
    for (const { trace } of this.lines) this.dot(source, trace, hover, values, 2.5);
    if (!selection) return;
    const { c } = this;
    const [from, to] = [this.px(selection.from), this.px(selection.to)];
    c.globalAlpha = 0.18;
    c.fillStyle = this.palette.focus;
    c.fillRect(from, EDGE, to - from, this.bottom - EDGE);
    c.globalAlpha = 1;
  }
}
