/** Which scopes are shown, over which time, and where the pointer is. */

import { AXES, type Axis } from '../../../app/api/types';
import { nameOf } from '../../../app/fields/fields.svelte';
import { gathered } from '../../../app/session/moments.svelte';
import { fromAddress, listOf, load, save, setAddress } from '../../../app/storage';
import { app } from '../../../app/store.svelte';
import { Ring } from '../../../app/stream/ring';
import type { Pointer } from '../../../plot/chart-pointer';
import { timeAt, type Range } from '../../../plot/range';
import type { Moment } from '../../../plot/scope-chart';
import type { SampleSource } from '../../../plot/source';
import {
  columnsOf,
  DEFAULT_SCOPES,
  SCOPES,
  scopeOf,
  type ScopeId,
} from '../../../plot/scope-catalog';
import { LiveSource } from './live-source';
import { STATISTICS, type Statistic } from './statistics';

export const SPANS = [1, 2, 5, 10, 20, 30] as const;

/** Curves' readouts change this often at most, ms. */
const READOUT = 100;

/** How much of a live session the plane shows, s. */
const TRAIL = 6;

/** Changes closer together than this have one mark, s. */
const DRAG = 1;

/** Shortest time axis, in control periods. */
const LEAST_SPAN = 4;

const NO_RING = new Ring(0, []);

class View {
  shown = $state.raw<readonly ScopeId[]>(keptScopes());
  variant = $state(load('variant', 'B'));
  axis = $state<Axis>(load<string>('axis', 'x') === 'y' ? 'y' : 'x');
  span = $state<number>(load('span', 10));
  zoom = $state.raw<Range | null>(null);
  follow = $state(true);
  /** Times of the cursors that were set, the first of which values are compared with. */
  cursors = $state.raw<readonly number[]>([]);
  /** The readings: the value at a moment, or a statistic of the measured interval. */
  statistic = $state<Statistic>(keptStatistic());
  /** Where the pointer is on the time axis; plain, as it moves with every event. */
  pointer: Pointer | null = null;
  /** Counts up to ten times a second while something moves: what readouts depend on. */
  beat = $state(0);
  private readonly live = new LiveSource(
    () => app.session.client?.ring ?? NO_RING,
    () => app.session.moments.period,
  );

  /** The variant that currents and forces are shown of. */
  readonly subject = $derived(
    app.variants.includes(this.variant) ? this.variant : (app.variants[0] ?? 'A'),
  );

  readonly scopes = $derived(
    this.shown.map((id) => scopeOf(id, app.variants, this.subject, this.axis)),
  );

  readonly columns = $derived(columnsOf(this.scopes, app.variants));

  /** Columns of a what-if: those, and what the trajectory's peaks are read off. */
  readonly previewColumns = $derived([
    ...new Set([
      ...this.columns,
      ...AXES.flatMap((axis) => [`${axis}.velocity_reference`, `${axis}.acceleration_reference`]),
    ]),
  ]);

  readonly moments = $derived.by((): readonly Moment[] => {
    const planned = (app.scenario?.schedule ?? []).map(({ time, set }) => ({
      time,
      label: labelOf(set),
    }));
    if (app.mode === 'whatif') return planned;
    const { period, pushes } = app.session.moments;
    if (period === 0) return planned;
    const made = app.session.info?.changes ?? [];
    // A drag is many changes; played faster, they are further apart.
    const changes = gathered(
      made.map(({ tick, set }) => ({ time: tick * period, set })),
      DRAG * Math.max(1, app.session.speed),
    ).map(({ time, set }) => ({ time, label: labelOf(set) }));
    return [...planned, ...changes, ...pushes].sort((a, b) => a.time - b.time);
  });

  get source(): SampleSource | null {
    if (app.mode === 'whatif') return app.whatif.answer?.source ?? null;
    return app.session.moments.period > 0 ? this.live : null;
  }

  /** What the time axis covers. */
  range(): Range {
    if (this.zoom) return this.zoom;
    const { source } = this;
    if (!source) return { from: 0, to: this.span };
    if (app.mode === 'whatif') {
      return { from: source.start, to: source.start + source.last * source.step };
    }
    const to = Math.max(source.last * source.step, this.span);
    return { from: to - this.span, to };
  }

  /** Time under the pointer: what slides through below it while it rests. */
  get hover(): number | null {
    return this.pointer && timeAt(this.range(), this.pointer.at);
  }

  /** The stretch of time that a drag has marked so far. */
  get selection(): Range | null {
    const { pointer } = this;
    if (!pointer || pointer.since === null) return null;
    const [from, to] = [pointer.since, pointer.at].sort((a, b) => a - b) as [number, number];
    const range = this.range();
    return { from: timeAt(range, from), to: timeAt(range, to) };
  }

  /** What the plane shows of that: of a live session the last laps only, the others lie below them. */
  trail(): Range {
    const range = this.range();
    if (app.mode === 'whatif' || this.zoom) return range;
    return { from: Math.max(range.from, app.session.time - TRAIL), to: range.to };
  }

  /** The stretch that statistics are of: between two cursors, else what is visible. */
  measured(): Range {
    const [from = 0, to = 0] = [...this.cursors].sort((a, b) => a - b);
    return this.cursors.length === 2 ? { from, to } : this.range();
  }

  /** The moment of the readouts: the second cursor, else under the pointer, else the newest. */
  moment(): number {
    const { hover, source } = this;
    const [, second] = this.cursors;
    if (second !== undefined) return second;
    if (hover !== null) return hover;
    if (!source) return Number.NaN;
    const newest = source.start + source.last * source.step;
    return app.mode === 'live' ? Math.min(newest, this.range().to) : Number.NaN;
  }

  toggle(id: ScopeId): void {
    const rest = this.shown.filter((other) => other !== id);
    if (rest.length === 0) return;
    const next = rest.length < this.shown.length ? rest : [...rest, id];
    this.shown = SCOPES.map((scope) => scope.id).filter((each) => next.includes(each));
    save('scopes', this.shown);
    setAddress({ scopes: this.shown.join(',') });
  }

  setSubject(variant: string, axis: Axis): void {
    this.variant = variant;
    this.axis = axis;
    save('variant', variant);
    save('axis', axis);
  }

  setSpan(span: number): void {
    this.span = span;
    this.zoom = null;
    save('span', span);
  }

  /** Zooms the time axis about the pointer, or about its middle. */
  zoomBy(ratio: number): void {
    const { from, to } = this.range();
    const centre = this.hover ?? (from + to) / 2;
    const length = Math.max(LEAST_SPAN * app.session.moments.period, (to - from) * ratio);
    const start = centre - ((centre - from) * length) / (to - from);
    this.look({ from: start, to: start + length });
  }

  /** Moves the time axis by a share of its length. */
  moveBy(share: number): void {
    const { from, to } = this.range();
    const shift = share * (to - from);
    this.look({ from: from + shift, to: to + shift });
  }

  /** Zooms to a range, as far as there are samples: to the whole of them, if it is that long. */
  private look({ from, to }: Range): void {
    const { source } = this;
    if (!source) return;
    const start = source.start + source.first * source.step;
    // A young session does not fill its time axis yet.
    const end = Math.max(
      source.start + source.last * source.step,
      start + (app.mode === 'live' ? this.span : 0),
    );
    const length = Math.min(to - from, end - start);
    const first = Math.min(Math.max(from, start), end - length);
    const whole = app.mode === 'whatif' && length === end - start;
    this.zoom = whole ? null : { from: first, to: first + length };
  }

  /** Sets a cursor; with two of them already, clears both. */
  setCursor(time: number): void {
    this.cursors = this.cursors.length < 2 ? [...this.cursors, time] : [];
  }

  /** By keyboard: where the pointer is, at the newest sample, or a third into what is visible. */
  placeCursor(): void {
    const { cursors } = this;
    const at = this.moment();
    const free = Number.isFinite(at) && !cursors.includes(at);
    this.setCursor(free ? at : timeAt(this.range(), (cursors.length + 1) / 3));
  }

  dragCursor(index: number, time: number): void {
    this.cursors = this.cursors.map((each, i) => (i === index ? time : each));
  }

  /** Moves the last cursor by a share of the time axis. */
  nudgeCursor(share: number): void {
    const { from, to } = this.range();
    const last = this.cursors.length - 1;
    const time = (this.cursors[last] ?? Number.NaN) + share * (to - from);
    this.dragCursor(last, Math.min(to, Math.max(from, time)));
  }

  setStatistic(statistic: Statistic): void {
    this.statistic = statistic;
    save('statistic', statistic);
  }

  nextStatistic(): void {
    const i = STATISTICS.findIndex(({ id }) => id === this.statistic);
    this.setStatistic(STATISTICS[(i + 1) % STATISTICS.length]?.id ?? 'value');
  }

  /** Back to the whole window or the newest samples, axes following the data. */
  reset(): void {
    this.zoom = null;
    this.follow = true;
    this.cursors = [];
  }

  /** Starts the readouts; returns what stops them. */
  start(): () => void {
    let seen = '';
    const timer = setInterval(() => {
      const key = `${this.source?.version} ${this.hover} ${this.moment()}`;
      if (key !== seen) this.beat += 1;
      seen = key;
    }, READOUT);
    return () => clearInterval(timer);
  }
}

function labelOf(set: object): string {
  return Object.keys(set)
    .map((path) => nameOf(path).replace('_', ''))
    .join(', ');
}

function keptStatistic(): Statistic {
  const kept = load('statistic', '' as string);
  return STATISTICS.find(({ id }) => id === kept)?.id ?? 'value';
}

function keptScopes(): readonly ScopeId[] {
  const address = fromAddress('scopes')?.split(',');
  const wanted: readonly string[] = address ?? load('scopes', DEFAULT_SCOPES, listOf(''));
  const known = SCOPES.map((scope) => scope.id).filter((id) => wanted.includes(id));
  return known.length > 0 ? known : DEFAULT_SCOPES;
}

export const view = new View();
