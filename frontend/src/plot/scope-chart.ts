/** One scope: a canvas that is fed from a source once a frame, when there is something new. */

import { boxOf, drawAxes, valueTicks, withUnit } from './axes';
import { AxisScale } from './axis-scale';
import { crisp, type Canvas } from './canvas';
import { ChartPointer, type ChartEvents, type TimeAxis } from './chart-pointer';
import type { Ink } from './palette';
import { calmRange, multiples, roundStep, type Range } from './range';
import type { SampleSource } from './source';
import { SourceCurve } from './source-curve';
import type { Dash, Look } from './types';
import type { Underlay } from './underlay';

/** Room for the numbers of the value axis and of the time axis, CSS pixels. */
const GUTTER = 66;
const AXIS = 22;
const EDGE = 6;
const RIGHT = 18;
/** Least distance between two times. */
const COLUMN = 70;
const MARKS_ACROSS = 8;
/** A time axis in seconds, however far one zooms in. */
export const TIME = { label: 'time', unit: 's', scale: { factor: 1, unit: 's' } };

export interface Trace extends Look {
  column: string;
  label: string;
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
  /** What lies behind the curves; the value axis includes it. */
  underlays: readonly Underlay[];
}

export class ScopeChart implements TimeAxis {
  range: Range = { from: 0, to: 1 };
  cursors: readonly number[] = [];
  private readonly c: CanvasRenderingContext2D;
  private readonly pointer: ChartPointer;
  private readonly curves: SourceCurve[];
  private x: AxisScale;
  private y: AxisScale;
  private values: Range | null = null;
  private drawn = '';

  constructor(
    private readonly canvas: Canvas,
    private readonly scope: Traces,
    events: ChartEvents,
    /** Whether the labels of moments stand in this scope, and the time axis under it. */
    private readonly first: boolean,
    private last: boolean,
  ) {
    this.last ||= canvas.alone;
    this.c = canvas.c;
    this.curves = scope.traces.map((trace) => new SourceCurve(trace.column, trace));
    this.x = this.timeScale();
    this.y = this.valueScale({ from: 0, to: 0 });
    this.pointer = new ChartPointer(canvas.element, this, events);
  }

  destroy(): void {
    this.pointer.destroy();
  }

  /** Draws, unless nothing has changed since the last time. */
  draw(source: SampleSource, state: ChartState): void {
    const { range, follow, moments, cursors, hover, selection, underlays } = state;
    const behind = underlays.map(({ version }) => version).join();
    const key = `${source.version} ${range.from} ${range.to} ${follow} ${moments.length} ${cursors.join()} ${hover} ${selection?.from} ${selection?.to} ${behind}`;
    if (key === this.drawn) return;
    this.drawn = key;
    this.range = range;
    this.cursors = cursors;
    this.x = this.timeScale();
    const [low, high] = this.read(source, underlays);
    if (follow || !this.values)
      this.values = calmRange(follow ? this.values : null, low, high, this.scope.still);
    this.y = this.valueScale(this.values);
    const { canvas, x, y } = this;
    canvas.clear();
    const times = withUnit(x.ticks(COLUMN), x);
    const ticks = { x: times, y: low <= high ? valueTicks(y) : [] };
    drawAxes(canvas, x, y, ticks, { bare: !this.last });
    this.moments(state);
    canvas.clipped(boxOf(x, y), () => {
      for (const each of underlays) each.draw(canvas, x, y);
      for (const curve of this.curves) curve.draw(canvas, source, x, y);
    });
    // Round markers at round times: they move along with the curve.
    const marked = multiples(range, roundStep((range.to - range.from) / MARKS_ACROSS));
    for (const { column, look } of this.curves) {
      if (look.marker) this.dots(source, column, look.ink, marked, 3);
      this.dots(source, column, look.ink, cursors, 2.5);
    }
    this.pointed(source, state);
  }

  /** The unit of the value axis, which readings share. */
  get scale() {
    return this.y.shown;
  }

  get ends(): readonly [number, number] {
    return this.x.pixels;
  }

  private timeScale(): AxisScale {
    const across = Math.max(1, this.canvas.width - GUTTER - RIGHT);
    return new AxisScale(TIME, this.range.from, this.range.to, [GUTTER, GUTTER + across]);
  }

  private valueScale({ from, to }: Range): AxisScale {
    const bottom = this.canvas.height - (this.last ? AXIS : EDGE);
    return new AxisScale({ label: '', unit: this.scope.unit }, from, to, [bottom, EDGE]);
  }

  /** Reads what the window holds; returns its least and largest value. */
  private read(source: SampleSource, underlays: readonly Underlay[]): [number, number] {
    const { range } = this;
    const [left, right] = this.ends;
    const pixels = Math.max(50, right - left);
    const bins = source.cut(range.from, range.to, pixels);
    const found = [
      ...this.curves.map((curve) => curve.read(source, bins)),
      ...underlays.map((each) => each.read(range, pixels)),
    ];
    return [Math.min(...found.map(([low]) => low)), Math.max(...found.map(([, high]) => high))];
  }

  /** Lines at moments and cursors, and what happened then, as far as there is room. */
  private moments({ moments, cursors, range }: ChartState): void {
    const { canvas, x } = this;
    const [bottom, top] = this.y.pixels;
    const shown = moments.filter(({ time }) => time >= range.from && time <= range.to);
    for (const { time } of shown) this.upright(time, 'axis', 'dot');
    canvas.font(10);
    cursors.forEach((time, i) => {
      if (time < range.from || time > range.to) return;
      this.upright(time, 'strong', i === 0 ? 'solid' : 'dash');
      const late = x.px(time) > canvas.width / 2;
      const [align, aside] = late ? (['right', -3] as const) : (['left', 3] as const);
      const look = { align, baseline: 'bottom', ink: 'axis' } as const;
      if (this.last) canvas.write(String(i + 1), x.px(time) + aside, bottom, look);
    });
    if (!this.first) return;
    let free = Number.NEGATIVE_INFINITY;
    for (const { time, label } of shown) {
      const px = x.px(time);
      const { width } = this.c.measureText(label);
      // At the right edge it stands before its line.
      const before = px + 3 + width > this.ends[1];
      const left = before ? px - 3 - width : px + 3;
      if (left < free) continue;
      canvas.write(label, left, top, { baseline: 'top', ink: 'axis' });
      free = left + width + 6;
    }
  }

  private upright(time: number, ink: Ink, dash: Dash): void {
    const at = crisp(this.x.px(time));
    const [bottom, top] = this.y.pixels;
    this.canvas.pen(ink, 1, dash);
    this.canvas.lines([[at, top, at, bottom]]);
  }

  private dots(
    source: SampleSource,
    column: string,
    ink: Ink = 'text',
    times: readonly number[],
    radius: number,
  ) {
    for (const time of times) {
      const value = source.at(column, time);
      if (!Number.isFinite(value)) continue;
      this.canvas.dot(this.x.px(time), this.y.px(value), radius, ink);
    }
  }

  /** The line under the pointer, the values there, and what a drag marks. */
  private pointed(source: SampleSource, { hover, selection }: ChartState): void {
    if (hover === null) return;
    const { c, x } = this;
    const [bottom, top] = this.y.pixels;
    this.upright(hover, 'strong', 'solid');
    for (const { column, look } of this.curves) this.dots(source, column, look.ink, [hover], 2.5);
    if (!selection) return;
    const [from, to] = [x.px(selection.from), x.px(selection.to)];
    c.globalAlpha = 0.18;
    c.fillStyle = this.canvas.palette.focus;
    c.fillRect(from, top, to - from, bottom - top);
    c.globalAlpha = 1;
  }
}
