/** The curves of one run: the whole of it, and whichever part is looked at, from the server. */

import { readCurves } from '../../app/api/curves-answer';
import { AXES, type RunDetail } from '../../app/api/types';
import { errorText } from '../../app/error-text';
import { LatestWins } from '../../app/latest-wins';
import type { Pointer } from '../../plot/chart-pointer';
import { timeAt, type Range } from '../../plot/range';
import type { Moment } from '../../plot/scope-chart';
import { StillSource } from '../../plot/source';
import { runWindow } from './runs-api';
import { markText } from './run-text';
import { channelsOf, planeRange, samplesOf, scopesOf, zoomed } from './run-window';

/** Bins of a scope and of the plane; more than either has pixels. */
const POINTS = 2000;

type Answer = ReturnType<typeof readCurves>;

export class RunCurves {
  /** Part of the run that is looked at; null for the whole. */
  zoom = $state.raw<Range | null>(null);
  /** A channel beside the following errors, such as `x.velocity`; empty without. */
  channel = $state('');
  cursors = $state.raw<readonly number[]>([]);
  problem = $state('');
  pointer: Pointer | null = null;
  readonly moments: readonly Moment[];
  readonly scopes = $derived.by(() => scopesOf(this.run, this.channel));
  readonly plane = $derived.by(() => planeRange(this.run, this.zoom));
  planeSource = $state.raw<StillSource | null>(null);
  private whole = $state.raw<StillSource | null>(null);
  private part = $state.raw<StillSource | null>(null);
  private readonly scopeQuestions = new LatestWins<Range | null>((zoom) => this.readScopes(zoom));
  private readonly planeQuestions = new LatestWins<Range>((range) => this.readPlane(range));

  constructor(readonly run: RunDetail) {
    this.moments = run.events.map((event) => ({
      time: event.tick * run.period,
      label: markText(event),
    }));
  }

  get range(): Range {
    return this.zoom ?? { from: 0, to: this.run.duration };
  }

  /** What is drawn: the part once it has come, until then the whole, which is coarser. */
  get source(): StillSource | null {
    const { part, range } = this;
    const covers =
      part &&
      part.start <= range.from + part.step &&
      part.start + part.last * part.step >= range.to - part.step;
    return this.zoom && covers ? part : this.whole;
  }

  get hover(): number | null {
    return this.pointer && timeAt(this.range, this.pointer.at);
  }

  get selection(): Range | null {
    const { pointer, range } = this;
    if (!pointer || pointer.since === null) return null;
    const [from, to] = [pointer.since, pointer.at].sort((a, b) => a - b) as [number, number];
    return { from: timeAt(range, from), to: timeAt(range, to) };
  }

  /** The moment that readings tell of: the last cursor, else under the pointer. */
  get moment(): number {
    return this.hover ?? this.cursors.at(-1) ?? Number.NaN;
  }

  /** Asks for curves of the part that is looked at. */
  load(): void {
    this.scopeQuestions.push(this.zoom);
    const { plane } = this;
    if (plane) this.planeQuestions.push(plane);
  }

  look(range: Range | null): void {
    this.zoom = range && zoomed(range, this.run);
    this.load();
  }

  /** Zooms about the pointer, or about the middle. */
  zoomBy(ratio: number): void {
    const { from, to } = this.range;
    const centre = this.hover ?? (from + to) / 2;
    const length = (to - from) * ratio;
    const start = centre - ((centre - from) * length) / (to - from);
    this.look({ from: start, to: start + length });
  }

  /** Moves the time axis by a share of its length. */
  moveBy(share: number): void {
    const { from, to } = this.range;
    const shift = share * (to - from);
    this.look({ from: from + shift, to: to + shift });
  }

  show(channel: string): void {
    this.channel = channel;
    this.whole = null;
    this.part = null;
    this.scopeQuestions.push(null);
    if (this.zoom) this.load();
  }

  setCursor(time: number): void {
    this.cursors = this.cursors.length < 2 ? [...this.cursors, time] : [];
  }

  dragCursor(index: number, time: number): void {
    this.cursors = this.cursors.map((each, i) => (i === index ? time : each));
  }

  reset(): void {
    this.cursors = [];
    this.look(null);
  }

  private async readScopes(zoom: Range | null): Promise<void> {
    const columns = this.scopes.flatMap(({ traces }) => traces.map(({ column }) => column));
    const source = await this.read(columns, zoom ?? { from: 0, to: this.run.duration });
    if (zoom) this.part = source ?? this.part;
    else this.whole = source ?? this.whole;
  }

  private async readPlane(range: Range): Promise<void> {
    const references = AXES.map((axis) => `${axis}.position_reference`);
    const errors = this.run.variants
      .slice(0, 2)
      .flatMap((variant) => AXES.map((axis) => `${variant}.${axis}.following_error`));
    this.planeSource = (await this.read([...references, ...errors], range)) ?? this.planeSource;
  }

  private async read(wanted: readonly string[], range: Range): Promise<StillSource | null> {
    const columns = this.run.columns.flatMap(({ name = '' }) =>
      wanted.includes(name) ? [name] : [],
    );
    if (columns.length === 0 || this.run.ticks === 0) return null;
    try {
      const query = { ...samplesOf(range, this.run), columns: columns.join(), points: POINTS };
      const { time, columns: curves }: Answer = readCurves(await runWindow(this.run.id, query));
      this.problem = '';
      return new StillSource(time.start, time.step, time.count, curves);
    } catch (error) {
      this.problem = errorText(error);
      return null;
    }
  }

  /** Channels that can be shown beside the following errors. */
  get channels() {
    return channelsOf(this.run);
  }
}
