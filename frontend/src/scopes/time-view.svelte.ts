/** What scopes show: curves over a stretch of time, cursors, and the readings at them. */

import type { Whose } from '../app/expressions/expressions.svelte';
import { app } from '../app/store.svelte';
import { isMath, mathParts, refusedBeside } from '../plot/math-column';
import type { Pointer } from '../plot/chart-pointer';
import { timeAt, type Range } from '../plot/range';
import { columnsOf, scopeOf, unitsOf, type Scope } from '../plot/scope-catalog';
import type { Moment } from '../plot/scope-chart';
import type { ScopeSpec } from '../plot/scope-layout';
import {
  differenceOf,
  extremes,
  type Channel,
  type SampleSource,
  type StillSource,
} from '../plot/source';
import type { Underlay } from '../plot/run-overlay';
import type { Layout } from './layout.svelte';
import { between, type Statistic } from './statistics';
import { channelsOf } from './trigger/detector';
import { Trigger } from './trigger/trigger.svelte';

/** Shortest time axis, in samples. */
const LEAST = 4;
/** Jumping to a moment shows so much of the time axis before it. */
const AHEAD = 0.25;

export abstract class TimeView {
  /** Part that is looked at; null for all that is shown by itself. */
  zoom = $state.raw<Range | null>(null);
  /** Whether value axes follow the data. */
  follow = $state(true);
  /** Times of the cursors that were set, the first of which values are compared with. */
  cursors = $state.raw<readonly number[]>([]);
  /** Values of cursors, by the place of their scope. */
  levels = $state.raw<Readonly<Record<number, readonly number[]>>>({});
  /** The readings: the value at a moment, or a statistic of the measured interval. */
  statistic = $state<Statistic>('value');
  /** Whether the readings of all traces are listed. */
  measuring = $state(false);
  /** The column whose peaks are looked for; empty for the first that is shown. */
  peaksOf = $state('');
  /** Where the pointer is on the time axis; plain, as it moves with every event. */
  pointer: Pointer | null = null;
  /** Counts up to ten times a second while something moves: what readouts depend on. */
  beat = $state(0);

  readonly trigger: Trigger = new Trigger(this);

  /** The math channels of the layout and of the trigger. */
  readonly math: readonly string[] = $derived.by(() => {
    const drawn = this.layout.scopes.flatMap(({ channels }) => channels);
    const watched = channelsOf(this.trigger.settings.conditions);
    const all = [...drawn, ...watched].filter(isMath);
    return all.filter((column, i) => all.indexOf(column) === i);
  });

  /** What is wrong with math channels of the layout; undefined while the server checks them. */
  readonly mathProblems: Readonly<Record<string, string | null | undefined>> = $derived.by(() => {
    const beside = refusedBeside(this.math);
    const problemOf = (column: string) => {
      const checked = app.expressions.of(this.whose, column);
      return checked?.problem ? checked.problem.message : checked && (beside.get(column) ?? null);
    };
    return Object.fromEntries(this.math.map((column) => [column, problemOf(column)]));
  });

  /** All channels, and those math channels that can be computed here. */
  readonly known: readonly Channel[] = $derived.by(() => {
    const computed = this.math.flatMap((name): Channel[] => {
      if (this.mathProblems[name] !== null) return [];
      const unit = app.expressions.of(this.whose, name)?.unit ?? '1';
      return [{ name, unit, meaning: mathParts(name).expression }];
    });
    return computed.length === 0 ? this.channels : [...this.channels, ...computed];
  });

  /** What a query of a file says of columns: nothing, or all channels and the math channels. */
  readonly exported: string = $derived.by(() => {
    const math = this.known.map(({ name }) => name).filter(isMath);
    return math.length > 0 ? `&columns=${encodeURIComponent(['*', ...math].join())}` : '';
  });

  abstract readonly layout: Layout;
  /** What the curves are drawn from; null while there is nothing. */
  abstract get source(): SampleSource | null;
  /** What the time axis covers without zoom. */
  abstract get home(): Range;
  /** How far there is anything to look at. */
  abstract get extent(): Range;
  /** Time between samples, s. */
  abstract get period(): number;
  /** All channels that can be shown. */
  abstract get channels(): readonly Channel[];
  abstract get variants(): readonly string[];
  /** Whose channels expressions read. */
  abstract get whose(): Whose;
  /** What the curves depend on: changes, pushes, stops. */
  abstract get moments(): readonly Moment[];
  /** The stretch that metrics are of. */
  abstract get window(): Range | null;
  /** The moment of the readouts; NaN for none. */
  abstract get moment(): number;

  /** The scopes of the layout that have a channel. */
  private readonly all: readonly Scope[] = $derived.by(() => {
    const units = unitsOf(this.known);
    return this.layout.scopes
      .map((spec, place) => scopeOf(units.size > 0 ? withKnown(spec, units) : spec, units, place))
      .filter(({ all }) => all.length > 0);
  });

  /** The scopes that are drawn in full: one, unless a person has opened more. */
  readonly scopes: readonly Scope[] = $derived.by(() => {
    const open = this.all.filter(({ place }) => this.layout.open.includes(place));
    return open.length > 0 ? open : this.all.slice(0, 1);
  });

  /** The others, of which a strip is shown. */
  readonly strips: readonly Scope[] = $derived.by(() =>
    this.all.filter((scope) => !this.scopes.includes(scope)),
  );

  /** Columns to read: of all scopes, so that showing one alone asks for nothing anew. */
  private readonly drawn: readonly string[] = $derived.by(() => columnsOf(this.all, this.variants));

  /** Those, and what the trigger has to see; the same array while nothing else is wanted. */
  readonly columns: readonly string[] = $derived.by(() => {
    const { drawn } = this;
    const more = this.trigger.channels.filter((column) => !drawn.includes(column));
    return more.length === 0 ? drawn : [...drawn, ...more];
  });

  /** What is marked on the time axis: moments, the clock, and the trigger of what is shown. */
  readonly marks: readonly Moment[] = $derived.by(() => {
    const { shown } = this.trigger;
    const marks = [...this.moments, ...this.clock].sort((a, b) => a.time - b.time);
    if (!shown || shown.free) return marks;
    return [...marks, { time: shown.time, label: 'trigger' }];
  });

  /** What people did to the clock: no trigger, and nothing that the curves depend on. */
  get clock(): readonly Moment[] {
    return [];
  }

  /** The moment that is played of a record; null where none is, or a cursor shows it. */
  get playhead(): number | null {
    return null;
  }

  /** Samples that come while one looks; null where all are there already. */
  get coming(): SampleSource | null {
    return null;
  }

  /** Another whenever what is there already has become another record. */
  get basis(): unknown {
    return null;
  }

  /** Every sample of a stretch of what is there already. */
  abstract samples(columns: readonly string[], range: Range): Promise<StillSource | null>;

  /** What lies behind the curves of a scope. */
  readonly behind?: (scope: Scope, range: Range) => readonly Underlay[];
  /** What else the legend of a scope says. */
  readonly note?: (scope: Scope) => string;
  /** Why a trace has no samples; empty where it should have. */
  readonly missing?: (column: string) => string;

  /** What asks why a trace is so large where the last cursor stands; null where that cannot be told. */
  readonly whyOf?: (column: string) => (() => void) | null;

  /** Which of several states the curves are of, as a name says it: `live`. */
  get state(): string {
    return '';
  }

  /** The whole that an overview shows, and what it is drawn from; null where there is none. */
  get overview(): { source: SampleSource; range: Range } | null {
    const { source } = this;
    return source && { source, range: this.extent };
  }

  get range(): Range {
    return this.zoom ?? this.home;
  }

  /** Time under the pointer: what slides through below it while it rests. */
  get hover(): number | null {
    return this.pointer && timeAt(this.range, this.pointer.at);
  }

  /** The stretch of time that a drag has marked so far. */
  get selection(): Range | null {
    const { pointer, range } = this;
    if (!pointer || pointer.since === null) return null;
    const [from, to] = [pointer.since, pointer.at].sort((a, b) => a - b) as [number, number];
    return { from: timeAt(range, from), to: timeAt(range, to) };
  }

  /** The stretch that statistics are of: between two cursors, else what is visible. */
  get measured(): Range {
    return this.cursors.length === 2 ? between(this.cursors, this.period) : this.range;
  }

  /** Looks at a stretch of time, as far as there is any; at the whole, where it is that long. */
  look(range: Range | null): void {
    this.zoom = range && this.within(range);
    this.looked();
  }

  protected looked(): void {
    // What has to be read then.
  }

  private within({ from, to }: Range): Range | null {
    const { extent, home, period } = this;
    const length = Math.min(Math.max(LEAST * period, to - from), extent.to - extent.from);
    const first = Math.min(Math.max(from, extent.from), extent.to - length);
    const whole = first === home.from && first + length === home.to;
    return whole ? null : { from: first, to: first + length };
  }

  /** Zooms the time axis about the pointer, or about its middle. */
  zoomBy(ratio: number): void {
    const { from, to } = this.range;
    const centre = this.hover ?? (from + to) / 2;
    const length = Math.max(LEAST * this.period, (to - from) * ratio);
    const start = centre - ((centre - from) * length) / (to - from);
    this.look({ from: start, to: start + length });
  }

  /** Moves the time axis by a share of its length. */
  moveBy(share: number): void {
    const { from, to } = this.range;
    const shift = share * (to - from);
    this.look({ from: from + shift, to: to + shift });
  }

  /** Brings a moment into view; from the whole, close enough to see what happens there. */
  jump(time: number): void {
    const { from, to } = this.range;
    const length = Math.min(to - from, (this.extent.to - this.extent.from) / 10);
    this.look({ from: time - AHEAD * length, to: time + (1 - AHEAD) * length });
  }

  /** Jumps to the next moment that is marked, or the one before. */
  nextMoment(way: 1 | -1): void {
    const { from, to } = this.range;
    const now = from + AHEAD * (to - from);
    const close = 1e-6 * (to - from) + this.period / 2;
    const times = this.marks.map(({ time }) => time).filter((time) => (time - now) * way > close);
    const next = way > 0 ? Math.min(...times) : Math.max(...times);
    if (Number.isFinite(next)) this.jump(next);
  }

  /** Sets a cursor; with two of them already, clears both. */
  setCursor(time: number): void {
    this.cursors = this.cursors.length < 2 ? [...this.cursors, time] : [];
  }

  /** By keyboard: where the pointer is, at the newest sample, or a third into what is visible. */
  placeCursor(): void {
    const { cursors, moment } = this;
    const free = Number.isFinite(moment) && !cursors.includes(moment);
    this.setCursor(free ? moment : timeAt(this.range, (cursors.length + 1) / 3));
  }

  dragCursor(index: number, time: number): void {
    this.cursors = this.cursors.map((each, i) => (i === index ? time : each));
  }

  /** Moves the last cursor by a share of the time axis. */
  nudgeCursor(share: number): void {
    const { from, to } = this.range;
    const last = this.cursors.length - 1;
    const time = (this.cursors[last] ?? Number.NaN) + share * (to - from);
    this.dragCursor(last, Math.min(to, Math.max(from, time)));
  }

  /** Goes with the last cursor to the next peak, or the one before, and reads it. */
  async nextPeak(way: 1 | -1): Promise<void> {
    const { nextPeak, tellPeak } = await import('./peaks');
    const peak = await nextPeak(this, way);
    if (peak) this.goTo(peak.time);
    tellPeak(this, peak, way);
  }

  /** Moves the last cursor to a moment, or sets one, and brings it into view. */
  private goTo(time: number): void {
    const { cursors, range } = this;
    if (time < range.from || time > range.to) {
      const from = time - (range.to - range.from) / 2;
      this.look({ from, to: from + range.to - range.from });
    }
    if (cursors.length > 0) this.dragCursor(cursors.length - 1, time);
    else this.setCursor(time);
  }

  /** Sets a cursor at a value of a scope; with two of them already, clears both. */
  setLevel(place: number, value: number): void {
    const there = this.levels[place] ?? [];
    this.levels = { ...this.levels, [place]: there.length < 2 ? [...there, value] : [] };
  }

  /** By keyboard: at the least and the most of the first trace that is shown, then none. */
  placeLevels(): void {
    const [scope] = this.scopes;
    const trace = scope?.traces[0];
    const { source } = this;
    if (!scope || !trace || !source) return;
    const set = (this.levels[scope.place] ?? []).length > 0;
    const ends = set ? [] : extremes(source, trace.column, this.measured).filter(Number.isFinite);
    this.levels = { ...this.levels, [scope.place]: ends };
  }

  /** Back to the whole window or the newest samples, axes following the data. */
  reset(): void {
    this.follow = true;
    this.layout.release();
    this.goHome();
  }

  /** Back to the whole window or the newest samples; the value axes of the layout stay. */
  goHome(): void {
    this.zoom = null;
    this.cursors = [];
    this.levels = {};
    this.looked();
  }

  /** Whether all value axes follow the data. */
  get automatic(): boolean {
    return this.follow && !this.layout.holds;
  }

  /** Has all value axes follow the data, or stay as they are. */
  setAutomatic(follow: boolean): void {
    this.follow = follow;
    if (follow) this.layout.release();
  }

  /** Whether anything differs from what `reset` restores. */
  get touched(): boolean {
    const levels = Object.values(this.levels).some((values) => values.length > 0);
    return this.zoom !== null || this.cursors.length > 0 || !this.automatic || levels;
  }
}

/** A scope with the channels that there are. */
function withKnown(spec: ScopeSpec, units: ReadonlyMap<string, string>): ScopeSpec {
  const known = (column: string) => {
    const difference = differenceOf(column);
    const sources = difference ? [difference.minuend, difference.subtrahend] : [column];
    return sources.every((source) => units.has(source));
  };
  return { ...spec, channels: spec.channels.filter(known) };
}
