/** One scope: a canvas that is fed from a source once a frame, when there is something new. */

import { scaleFor, type Scale } from '../ui/units';
import { pointsOf, writeCurve, type Bins } from './bins';
import type { Ink, Palette } from './palette';
import { drawQuantileBand, bandExtremes, type QuantileBand } from './quantile-band';
import { calmRange, multiples, roundStep, timeAt, type Range } from './range';
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
/** A pointer that moves less than this between down and up has clicked, CSS pixels. */
const CLICK = 4;

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

/** Where a pointer is, and where its drag began, as shares of the time axis. */
export interface Pointer {
  at: number;
  since: number | null;
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

export interface ChartEvents {
  zoom(range: Range): void;
  reset(): void;
  /** A click: a cursor is to be set. */
  set(time: number): void;
  drag(cursor: number, time: number): void;
  point(pointer: Pointer | null): void;
}

interface Line {
  trace: Trace;
  values: Float32Array;
}

export class Chart {
  private readonly c: CanvasRenderingContext2D;
  private readonly lines: Line[];
  private bins: Bins = { first: 0, size: 1, count: 0, paired: false };
  private minimum = new Float32Array(0);
  private maximum = new Float32Array(0);
  private values: Range | null = null;
  private quantileBands: readonly QuantileBand[] = [];
  private drawn = '';
  private empty = true;
  private width = 1;
  private height = 1;
  private range: Range = { from: 0, to: 1 };
  private cursors: readonly number[] = [];
  /** Where a button went down, CSS pixels. */
  private pressed: number | null = null;
  /** The cursor that is dragged, or -1. */
  private dragged = -1;
  private readonly font: string;
  private readonly stop = new AbortController();

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly scope: Traces,
    private readonly palette: Palette,
    private readonly events: ChartEvents,
    /** Whether the labels of moments stand in this scope, and the time axis under it. */
    private readonly first: boolean,
    private readonly last: boolean,
  ) {
    this.c = canvas.getContext('2d') as CanvasRenderingContext2D;
    this.font = getComputedStyle(canvas).fontFamily;
    this.lines = scope.traces.map((trace) => ({ trace, values: new Float32Array(0) }));
    const { signal } = this.stop;
    canvas.addEventListener('pointerdown', (event) => this.down(event), { signal });
    canvas.addEventListener('pointermove', (event) => this.move(event), { signal });
    canvas.addEventListener('pointerup', (event) => this.up(event), { signal });
    canvas.addEventListener('pointerleave', () => this.leave(), { signal });
    canvas.addEventListener('pointercancel', () => this.leave(), { signal });
    canvas.addEventListener('dblclick', () => events.reset(), { signal });
    this.resize();
  }

  destroy(): void {
    this.stop.abort();
    this.events.point(null);
  }

  resize(): void {
    this.width = Math.max(1, this.canvas.clientWidth);
    this.height = Math.max(1, this.canvas.clientHeight);
    this.canvas.width = Math.round(this.width * devicePixelRatio);
    this.canvas.height = Math.round(this.height * devicePixelRatio);
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
    const { c } = this;
    c.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
    c.clearRect(0, 0, this.width, this.height);
    this.axes(this.values);
    this.moments(state);
    this.bands(this.values);
    this.curves(source, this.values);
    this.markers(source, this.values);
    this.pointer(source, this.values, state);
  }

  /** The unit of the value axis, which readings share. */
  get scale(): Scale {
    const { from, to } = this.values ?? { from: 0, to: 0 };
    return scaleFor(Math.max(-from, to), this.scope.unit);
  }

  private get across(): number {
    return Math.max(1, this.width - GUTTER - RIGHT);
  }

  private get bottom(): number {
    return this.height - (this.last ? AXIS : EDGE);
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
    if (this.quantileBands.length === 0) return;
    const { c } = this;
    c.save();
    c.beginPath();
    c.rect(GUTTER, EDGE, this.across, this.bottom - EDGE);
    c.clip();
    const x = (time: number) => this.px(time);
    const y = (value: number) => this.py(value, values);
    for (const ribbon of this.quantileBands)
      drawQuantileBand(c, ribbon, this.palette[ribbon.ink], x, y);
    c.restore();
  }

  private axes(values: Range): void {
    const { c, palette, bottom } = this;
    c.strokeStyle = palette.grid;
    c.fillStyle = palette.axis;
    c.font = `11px ${this.font}`;
    c.lineWidth = 1;
    c.setLineDash([]);
    c.beginPath();
    c.textAlign = 'center';
    c.textBaseline = 'top';
    const times = timeSplits(this.range, this.across);
    times.forEach((time, i) => {
      const x = Math.round(this.px(time)) + 0.5;
      c.moveTo(x, EDGE);
      c.lineTo(x, bottom);
      if (this.last) c.fillText(`${time}${i === times.length - 1 ? ' s' : ''}`, x, bottom + 5);
    });
    c.textAlign = 'right';
    c.textBaseline = 'middle';
    const splits = this.empty ? [] : valueSplits(values, bottom - EDGE);
    const texts = valueTexts(splits, this.scope.unit);
    splits.forEach((split, i) => {
      const y = Math.round(this.py(split, values)) + 0.5;
      c.moveTo(GUTTER, y);
      c.lineTo(this.width - RIGHT, y);
      c.fillText(texts[i] as string, GUTTER - 6, y);
    });
    c.stroke();
  }

  /** Lines at moments and cursors, and what happened then, as far as there is room. */
  private moments({ moments, cursors, range }: ChartState): void {
    const shown = moments.filter(({ time }) => time >= range.from && time <= range.to);
    for (const { time } of shown) this.upright(time, 'axis', [2, 3]);
    const { c } = this;
    c.font = `10px ${this.font}`;
    c.textBaseline = 'bottom';
    cursors.forEach((time, i) => {
      if (time < range.from || time > range.to) return;
      this.upright(time, 'strong', i === 0 ? [] : [6, 3]);
      c.textAlign = this.px(time) > this.width / 2 ? 'right' : 'left';
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
    const { c } = this;
    const x = Math.round(this.px(time)) + 0.5;
    c.strokeStyle = this.palette[ink];
    c.lineWidth = 1;
    c.setLineDash(dash);
    c.beginPath();
    c.moveTo(x, EDGE);
    c.lineTo(x, this.bottom);
    c.stroke();
  }

  private curves(source: Source, values: Range): void {
    const { c } = this;
    c.save();
    c.beginPath();
    c.rect(GUTTER, EDGE, this.across, this.bottom - EDGE);
    c.clip();
    c.lineJoin = 'bevel';
    for (const line of this.lines) this.curve(source, line, values);
    c.restore();
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
    const { c } = this;
    c.fillStyle = this.palette[ink];
    c.beginPath();
    c.arc(this.px(time), this.py(value, values), radius, 0, 2 * Math.PI);
    c.fill();
  }

  /** The line under the pointer, the values there, and what a drag marks. */
  private pointer(source: Source, values: Range, { hover, cursors, selection }: ChartState): void {
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

  private share(x: number): number {
    return Math.min(1, Math.max(0, (x - GUTTER) / this.across));
  }

  private down(event: PointerEvent): void {
    if (event.button !== 0 || event.offsetX < GUTTER) return;
    this.canvas.setPointerCapture(event.pointerId);
    this.dragged = this.cursorAt(event.offsetX);
    if (this.dragged < 0) this.pressed = event.offsetX;
  }

  private move({ offsetX: x }: PointerEvent): void {
    const { pressed, dragged: cursor } = this;
    if (cursor >= 0) this.events.drag(cursor, timeAt(this.range, this.share(x)));
    else this.canvas.style.cursor = this.cursorAt(x) < 0 ? '' : 'ew-resize';
    if (pressed === null && (x < GUTTER || x > GUTTER + this.across)) return this.leave();
    const dragged = pressed !== null && Math.abs(x - pressed) >= CLICK;
    this.events.point({ at: this.share(x), since: dragged ? this.share(pressed) : null });
  }

  private up({ offsetX: x }: PointerEvent): void {
    const { pressed } = this;
    this.dragged = -1;
    if (pressed === null) return;
    this.pressed = null;
    const [from, to] = [this.share(Math.min(x, pressed)), this.share(Math.max(x, pressed))];
    this.events.point({ at: this.share(x), since: null });
    if (Math.abs(x - pressed) < CLICK) this.events.set(timeAt(this.range, to));
    else this.events.zoom({ from: timeAt(this.range, from), to: timeAt(this.range, to) });
  }

  /** The cursor that a pointer can take hold of, or -1. */
  private cursorAt(x: number): number {
    return this.cursors.findIndex((time) => Math.abs(this.px(time) - x) <= CLICK);
  }

  private leave(): void {
    this.pressed = null;
    this.dragged = -1;
    this.events.point(null);
  }
}
