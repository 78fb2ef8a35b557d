/** One scope: a canvas that is fed from a source once a frame, when there is something new. */

import { boxOf, drawAxes, valueTicks, withUnit } from './axes';
import { AxisScale } from './axis-scale';
import type { Bins } from './bins';
import { crisp, type Canvas } from './canvas';
import { ScrollingCurves } from './scrolling-curves';
import { ChartPointer, type ChartEvents, type TimeAxis } from './chart-pointer';
import type { Ink } from './palette';
import { axisParts, endsOf } from './axis-parts';
import { calmRange, multiples, roundStep, type Range } from './range';
import type { SampleSource } from './source';
import { SourceCurve } from './source-curve';
import type { Dash, Look } from './types';
import type { Underlay } from './run-overlay';

/** Room for the numbers of the value axis and of the time axis, CSS pixels. */
const GUTTER = 66;
const AXIS = 22;
const EDGE = 6;
/** Right of the curves: without and with a second value axis. */
export const RIGHT = { plain: 18, second: 62 } as const;
/** Of a strip, around its curves. */
const STRIP = 2;
/** Least distance between two times. */
const COLUMN = 70;
/** A label with fewer letters of it tells nothing. */
const READABLE = 8;
/** Height of a line of small text. */
const LETTERS = 11;
const MARKS_ACROSS = 8;
/** A time axis in seconds, however far one zooms in. */
export const TIME = { label: 'time', unit: 's', scale: { factor: 1, unit: 's' } };

export interface Trace extends Look {
  column: string;
  label: string;
  /** SI; without it, that of the scope. */
  unit?: string;
  /** Whether it has a value axis of its own. */
  own?: boolean;
}

/** Where a chart stands among those that share its time axis. */
export interface Standing {
  /** The labels of moments stand in it. */
  first?: boolean;
  /** The time axis stands under it. */
  last?: boolean;
  /** Curves alone, small: no axes, no pointer. */
  strip?: boolean;
}

/** What a chart draws over time. */
export interface Traces {
  unit: string;
  traces: Trace[];
  /** Span of the value axis while all is zero. */
  still?: number;
  /**
   * Whether a trace that is far smaller than the largest gets an axis of its own by itself: with the
   * same zero and the same ticks, a round factor smaller.
   */
  spread?: boolean;
}

/** A moment worth a line on the time axis: a change of parameters, a push. */
export interface Moment {
  time: number;
  label: string;
}

export interface ChartState {
  range: Range;
  /** Whether the value axes follow the data. */
  follow: boolean;
  /** Ends of the first value axis; without them it follows the data. */
  hold?: readonly [number, number] | null;
  moments: readonly Moment[];
  /** Times of the cursors that were set. */
  cursors: readonly number[];
  /** Values of the cursors that were set, on the first value axis. */
  levels?: readonly number[];
  /** Time under the pointer of any scope, and what its drag has marked. */
  hover: number | null;
  /** The moment that is played. */
  playhead?: number | null;
  selection: Range | null;
  /** What lies behind the curves; the value axis includes it. */
  underlays: readonly Underlay[];
  /** Room at the right, the same for scopes that share a time axis. */
  right?: number;
}

/** Curves that share a value axis. */
interface Group {
  unit: string;
  curves: SourceCurve[];
  values: Range | null;
  y: AxisScale;
  /** How much smaller than the first axis it is; 0 where it has ends of its own. */
  part: number;
}

export class ScopeChart implements TimeAxis {
  range: Range = { from: 0, to: 1 };
  cursors: readonly number[] = [];
  levels: readonly number[] = [];
  private readonly c: CanvasRenderingContext2D;
  private readonly pointer: ChartPointer | null;
  private readonly curves: SourceCurve[];
  private groups: Group[];
  private right: number = RIGHT.plain;
  private x: AxisScale;
  private readonly first: boolean;
  private readonly last: boolean;
  private readonly strip: boolean;
  private readonly gutter: number;
  /** Where samples come one after the other and nothing lies behind them. */
  private picture: ScrollingCurves | null = null;
  private drawn = '';

  constructor(
    private readonly canvas: Canvas,
    private readonly scope: Traces,
    events: ChartEvents | null,
    { first = false, last = false, strip = false }: Standing,
  ) {
    this.first = first;
    this.last = last || canvas.alone;
    this.strip = strip && !canvas.alone;
    this.gutter = this.strip ? STRIP : GUTTER;
    this.c = canvas.c;
    this.curves = scope.traces.map((trace) => new SourceCurve(trace.column, trace));
    this.x = this.timeScale();
    this.groups = groupsOf(scope).map(({ unit, places }) =>
      this.group(
        unit,
        places.map((place) => this.curves[place] as SourceCurve),
      ),
    );
    this.pointer = events && !this.strip ? new ChartPointer(canvas.element, this, events) : null;
  }

  private group(unit: string, curves: SourceCurve[], part = 0): Group {
    return { unit, curves, values: null, y: this.valueScale({ from: 0, to: 0 }, unit), part };
  }

  destroy(): void {
    this.pointer?.destroy();
  }

  /** Draws, unless nothing has changed since the last time. */
  draw(source: SampleSource, state: ChartState): void {
    const { range, follow, hold, moments, cursors, levels, hover, selection, underlays } = state;
    const behind = underlays.map(({ version }) => version).join();
    const key = `${source.version} ${range.from} ${range.to} ${follow} ${hold?.join()} ${moments.length} ${cursors.join()} ${levels?.join()} ${hover} ${state.playhead} ${selection?.from} ${selection?.to} ${behind} ${state.right}`;
    if (key === this.drawn) return;
    this.drawn = key;
    this.range = range;
    this.cursors = cursors;
    this.levels = levels ?? [];
    this.right = this.strip ? STRIP : (state.right ?? RIGHT.plain);
    const grows = source.revision !== undefined && underlays.length === 0 && !this.canvas.alone;
    this.picture = grows ? (this.picture ?? new ScrollingCurves(this.canvas)) : null;
    this.x = this.timeScale();
    const bins = source.cut(this.x.from, this.x.to, this.across);
    const kept = this.picture?.kept(source, bins) ?? 0;
    const any = this.read(source, state, bins, kept);
    const { canvas, x, y } = this;
    canvas.clear();
    if (!this.strip) {
      const times = withUnit(x.ticks(COLUMN), x);
      drawAxes(canvas, x, y, { x: times, y: any ? valueTicks(y) : [] }, { bare: !this.last });
      this.secondAxis();
      this.moments(state);
    }
    if (this.picture) this.picture.draw(source, this.groups, x, bins, kept);
    else {
      canvas.clipped(boxOf(x, y), () => {
        for (const each of underlays) each.draw(canvas, x, this.groupOf(each)?.y ?? y);
        for (const group of this.groups) {
          for (const curve of group.curves) curve.draw(canvas, source, x, group.y);
        }
      });
    }
    if (this.strip) return;
    // Round markers at round times: they move along with the curve.
    const marked = multiples(range, roundStep((range.to - range.from) / MARKS_ACROSS));
    for (const group of this.groups) {
      for (const { column, look } of group.curves) {
        if (look.marker) this.dots(source, column, look.ink, marked, 3, group.y);
        this.dots(source, column, look.ink, cursors, 2.5, group.y);
      }
    }
    this.valueCursors();
    this.played(source, state.playhead ?? null);
    this.pointed(source, state);
  }

  /** The unit of the first value axis. */
  get scale() {
    return this.y.shown;
  }

  /** The units that the traces are read in, in their order. */
  get scales() {
    return this.curves.map(
      (curve) => (this.groups.find(({ curves }) => curves.includes(curve))?.y ?? this.y).shown,
    );
  }

  /** Ends of the value axis of each trace that was given one by itself, in their order; else null. */
  get spreads(): readonly (AxisScale | null)[] {
    return this.curves.map(
      (curve) =>
        this.groups.find(({ part, curves }) => part > 0 && curves.includes(curve))?.y ?? null,
    );
  }

  get ends(): readonly [number, number] {
    return this.x.pixels;
  }

  /** The first value axis. */
  get y(): AxisScale {
    return this.groups[0]?.y ?? this.valueScale({ from: 0, to: 1 }, this.scope.unit);
  }

  /** Width of the curves, CSS pixels. */
  private get across(): number {
    return Math.max(50, this.canvas.width - this.gutter - this.right);
  }

  private timeScale(): AxisScale {
    const { range, across } = this;
    const [from, to] = this.picture?.snapped(range, across) ?? [range.from, range.to];
    return new AxisScale(TIME, from, to, [this.gutter, this.gutter + across]);
  }

  private valueScale({ from, to }: Range, unit: string): AxisScale {
    const edge = this.strip ? STRIP : EDGE;
    const bottom = this.canvas.height - (this.last && !this.strip ? AXIS : edge);
    return new AxisScale({ label: '', unit }, from, to, [bottom, edge]);
  }

  /** The curves whose value axis something behind them shares: those with its column, else the first. */
  private groupOf({ column }: Underlay): Group | undefined {
    const of = ({ curves }: Group) => curves.some((curve) => curve.column === column);
    return this.groups.find(of) ?? this.groups[0];
  }

  /** Reads what the window holds and fits the value axes; whether there is anything. */
  private read(
    source: SampleSource,
    { follow, hold, underlays }: ChartState,
    bins: Bins,
    kept: number,
  ): boolean {
    const { range, across } = this;
    let any = false;
    const read = new Map(this.curves.map((curve) => [curve, curve.read(source, bins, kept)]));
    const behind = new Map(underlays.map((each) => [each, each.read(range, across)]));
    if (this.scope.spread && follow) this.spread(read, behind);
    const extentsOf = (group: Group) => [
      ...group.curves.map((curve) => read.get(curve) as readonly [number, number]),
      ...[...behind].flatMap(([each, extent]) => (this.groupOf(each) === group ? [extent] : [])),
    ];
    // The axes that are a part of the first one have its zero: it holds what they have to, so much larger.
    const larger = this.groups
      .filter(({ part }) => part > 0)
      .flatMap((group) =>
        extentsOf(group).map(([low, high]) => [low / group.part, high / group.part] as const),
      );
    this.groups.forEach((group, place) => {
      const extents = [...extentsOf(group), ...(place === 0 ? larger : [])];
      const low = Math.min(...extents.map(([least]) => least));
      const high = Math.max(...extents.map(([, most]) => most));
      if (place === 0 && low <= high) any = true;
      if (group.part > 0) {
        const { from, to } = this.y;
        group.y = this.valueScale({ from: from * group.part, to: to * group.part }, group.unit);
        return;
      }
      if (follow || !group.values) {
        group.values = calmRange(follow ? group.values : null, low, high, this.scope.still);
      }
      const held = place === 0 && hold ? { from: hold[0], to: hold[1] } : group.values;
      group.y = this.valueScale(held, group.unit);
    });
    return any;
  }

  /** Gives curves that are far smaller than the largest of their axis, with what lies behind them, one of their own. */
  private spread(
    read: ReadonlyMap<SourceCurve, readonly [number, number]>,
    behind: ReadonlyMap<Underlay, readonly [number, number]>,
  ): void {
    const [main] = this.groups;
    if (!main) return;
    const together = this.groups.filter((group) => group === main || group.part > 0);
    const curves = this.curves.filter((curve) =>
      together.some((group) => group.curves.includes(curve)),
    );
    const ends = curves.map((curve) =>
      endsOf([
        read.get(curve) as readonly [number, number],
        ...[...behind].flatMap(([{ column }, extent]) => (column === curve.column ? [extent] : [])),
      ]),
    );
    const parts = axisParts(
      ends,
      curves.map((curve) => together.find((group) => group.curves.includes(curve))?.part ?? 0),
    );
    if (
      curves.every((curve, i) =>
        together.find(({ part }) => part === parts[i])?.curves.includes(curve),
      )
    )
      return;
    const others = this.groups.filter((group) => !together.includes(group));
    const groups = [0, ...new Set(parts.filter((part) => part > 0))].map((part) => ({
      ...(part === 0 ? main : this.group(main.unit, [], part)),
      curves: curves.filter((_, i) => parts[i] === part),
    }));
    this.groups = [...groups, ...others];
  }

  /** Numbers of the second value axis, at the right edge, in the colour of its curve. */
  private secondAxis(): void {
    const second = this.groups[1];
    if (!second || this.right === RIGHT.plain) return;
    const { canvas, x } = this;
    const [, at] = x.pixels;
    const ink = second.curves.length === 1 ? (second.curves[0]?.look.ink ?? 'axis') : 'axis';
    canvas.font();
    canvas.pen(ink);
    const level =
      second.part > 0
        ? withUnit(
            second.y.named(valueTicks(this.y).map(({ value }) => value * second.part)),
            second.y,
          )
        : valueTicks(second.y);
    canvas.lines(level.map(({ value }) => {
      const py = crisp(second.y.px(value));
      return [at, py, at + 4, py] as const;
    })); // prettier-ignore
    for (const { value, text } of level) canvas.write(text, at + 7, second.y.px(value), { ink });
  }

  /** Lines at values that were set, and how far apart they are. */
  private valueCursors(): void {
    if (this.levels.length === 0) return;
    const { canvas, y } = this;
    const [left, right] = this.ends;
    const [first] = this.levels;
    canvas.font(10);
    const lines = this.levels.map((value) => crisp(y.px(value)));
    this.levels.forEach((value, i) => {
      if (!y.holds(value)) return;
      const at = lines[i] as number;
      canvas.pen('strong', 1, i === 0 ? 'solid' : 'dash');
      canvas.lines([[left, at, right, at]]);
      const apart = i > 0 && first !== undefined ? `  Δ ${y.text(value - first)}` : '';
      // Of two that are near, the lower one has its text below its line; at the top, beside the other.
      const near = lines.some((other) => other < at && at - other < 2 * LETTERS);
      const high = at - LETTERS < EDGE;
      const look = {
        align: high ? 'left' : 'right',
        baseline: near || high ? 'top' : 'bottom',
        ink: 'axis',
        rim: canvas.palette.panel,
      } as const;
      const text = `${y.text(value)}${apart} ${y.shown.unit}`;
      canvas.write(text, high ? left + 3 : right - 3, at + (near || high ? 2 : -1), look);
    });
  }

  /** Lines at moments and cursors, and what happened then, as far as there is room. */
  private moments({ moments, cursors, range }: ChartState): void {
    const { canvas, x } = this;
    const [bottom, top] = this.y.pixels;
    const shown = moments.filter(({ time }) => time >= range.from && time <= range.to);
    if (shown.length === 0 && cursors.length === 0) return;
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
    const [from, to] = this.ends;
    let free = from;
    shown.forEach(({ time, label }, i) => {
      const px = x.px(time);
      const next = shown[i + 1];
      // After its line, as far as the next one; before it where there is more room.
      const [before, after] = [px - 6 - free, (next ? x.px(next.time) : to) - px - 6];
      const { width } = this.c.measureText(label);
      const ahead = after >= Math.min(width, before);
      const text = this.shortened(label, ahead ? after : before);
      if (text === '') return;
      const [align, aside] = ahead ? (['left', 3] as const) : (['right', -3] as const);
      const rim = canvas.palette.panel;
      canvas.write(text, px + aside, top, { align, baseline: 'top', ink: 'axis', rim });
      free = ahead ? px + 3 + this.c.measureText(text).width : px;
    });
  }

  /** As much of a text as there is room for; nothing where that is too little to read. */
  private shortened(text: string, room: number): string {
    const { width } = this.c.measureText(text);
    if (width <= room) return text;
    const kept = Math.floor((text.length * room) / width) - 1;
    return kept < READABLE ? '' : `${text.slice(0, kept).trimEnd()}…`;
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
    y: AxisScale,
  ) {
    const [bottom, top] = y.pixels;
    for (const time of times) {
      const py = y.px(source.at(column, time));
      if (!(py >= top && py <= bottom)) continue;
      this.canvas.dot(this.x.px(time), py, radius, ink);
    }
  }

  /** The line at the moment that is played, and the values there. */
  private played(source: SampleSource, playhead: number | null): void {
    const { from, to } = this.range;
    if (playhead === null || playhead < from || playhead > to) return;
    this.upright(playhead, 'axis', 'solid');
    for (const { curves, y } of this.groups) {
      for (const { column, look } of curves) {
        this.dots(source, column, look.ink, [playhead], 2.5, y);
      }
    }
  }

  /** The line under the pointer, the values there, and what a drag marks. */
  private pointed(source: SampleSource, { hover, selection }: ChartState): void {
    if (hover === null) return;
    const { c, x } = this;
    const [bottom, top] = this.y.pixels;
    this.upright(hover, 'strong', 'solid');
    for (const { curves, y } of this.groups) {
      for (const { column, look } of curves) this.dots(source, column, look.ink, [hover], 2.5, y);
    }
    if (!selection) return;
    const [from, to] = [x.px(selection.from), x.px(selection.to)];
    c.globalAlpha = 0.18;
    c.fillStyle = this.canvas.palette.focus;
    c.fillRect(from, top, to - from, bottom - top);
    c.globalAlpha = 1;
  }
}

/** Which traces share a value axis: those of a unit, but for those with an axis of their own. */
export function groupsOf({ unit, traces }: Traces): { unit: string; places: number[] }[] {
  const groups = new Map<string, { unit: string; places: number[] }>();
  traces.forEach((trace, place) => {
    const of = trace.unit ?? unit;
    const key = trace.own === true ? trace.column : `unit ${of}`;
    const group = groups.get(key) ?? { unit: of, places: [] };
    group.places.push(place);
    groups.set(key, group);
  });
  return [...groups.values()];
}
