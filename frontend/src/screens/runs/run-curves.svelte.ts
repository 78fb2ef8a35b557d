/** The curves of one run: the whole of it, and whichever part is looked at, from the server. */

import { AXES, type RunDetail } from '../../app/api/types';
import { BINS } from '../../app/runs/run-range';
import { RunSource } from '../../app/runs/run-source.svelte';
import { markText } from '../../app/runs/run-text';
import type { Pointer } from '../../plot/chart-pointer';
import { timeAt, type Range } from '../../plot/range';
import type { Moment } from '../../plot/scope-chart';
import type { StillSource } from '../../plot/source';
import { channelsOf, planeRange, scopesOf, zoomed, type Scope } from './run-window';

export class RunCurves {
  /** Part of the run that is looked at; null for the whole. */
  zoom = $state.raw<Range | null>(null);
  /** A channel beside the following errors, such as `x.velocity`; empty without. */
  channel = $state('');
  cursors = $state.raw<readonly number[]>([]);
  pointer: Pointer | null = null;
  readonly moments: readonly Moment[];
  readonly scopes = $derived.by(() => this.chosenScopes());
  readonly plane = $derived.by(() => this.chosenPlane());
  private readonly ofScopes: RunSource;
  private readonly ofPlane: RunSource;

  constructor(readonly run: RunDetail) {
    this.ofScopes = new RunSource(run);
    this.ofPlane = new RunSource(run, false);
    this.moments = run.events.map((event) => ({
      time: event.tick * run.period,
      label: markText(event),
    }));
  }

  get range(): Range {
    return this.zoom ?? { from: 0, to: this.run.duration };
  }

  get source(): StillSource | null {
    return this.ofScopes.over(this.range);
  }

  get planeSource(): StillSource | null {
    return this.ofPlane.part;
  }

  get problem(): string {
    return this.ofScopes.problem || this.ofPlane.problem;
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
    const { zoom, plane } = this;
    this.ofScopes.choose(this.scopes.flatMap(({ traces }) => traces.map(({ column }) => column)));
    this.ofScopes.read(zoom && { range: zoom, points: BINS });
    if (!plane) return;
    this.ofPlane.choose(planeColumns(this.run.variants));
    this.ofPlane.read({ range: plane, points: BINS });
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
    this.load();
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

  protected chosenScopes(): readonly Scope[] {
    return scopesOf(this.run, this.channel);
  }

  protected chosenPlane(): Range | null {
    return planeRange(this.run, this.zoom);
  }

  /** Channels that can be shown beside the following errors. */
  get channels() {
    return channelsOf(this.run);
  }
}

function planeColumns(variants: readonly string[]): string[] {
  const references = AXES.map((axis) => `${axis}.position_reference`);
  const errors = variants
    .slice(0, 2)
    .flatMap((variant) => AXES.map((axis) => `${variant}.${axis}.following_error`));
  return [...references, ...errors];
}
