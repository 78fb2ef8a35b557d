/** The curves of one run: the whole of it, and whichever part is looked at, from the server. */

import { AXES, type RunDetail } from '../../app/api/types';
import type { Whose } from '../../app/expressions/expressions.svelte';
import { RunSource } from '../../parts/runs/run-source.svelte';
import { markText, timeOf } from '../../parts/runs/run-text';
import { Layout } from '../../scopes/layout.svelte';
import { TimeView } from '../../scopes/time-view.svelte';
import type { Range } from '../../plot/range';
import { LAYOUTS } from '../../plot/scope-catalog';
import type { Moment } from '../../plot/scope-chart';
import type { ScopeSpec } from '../../plot/scope-layout';
import type { Channel, StillSource } from '../../plot/source';
import { errorScopes, measuredWindow, planeRange } from './run-window';

/** The plane of a whole run has many laps, each of which goes round. */
const PLANE_FINER = 4;

export class RunCurves extends TimeView {
  readonly layout: Layout;
  readonly moments: readonly Moment[];
  readonly channels: readonly Channel[];
  readonly plane = $derived.by(() => this.chosenPlane());
  private readonly ofScopes: RunSource;
  private readonly ofPlane: RunSource;

  constructor(
    readonly run: RunDetail,
    key = 'runs.layout',
  ) {
    super();
    this.layout = new Layout({ key, shipped: (name) => this.shipped(name) });
    this.channels = run.columns.map(({ name = '', unit }) => ({ name, unit: unit ?? '1' }));
    this.ofScopes = new RunSource(run);
    this.ofPlane = new RunSource(run, false, PLANE_FINER);
    this.moments = run.events
      .map((event) => ({ time: timeOf(event, run), label: markText(event) }))
      .filter(({ time }) => time >= 0);
  }

  get variants(): readonly string[] {
    return this.run.variants;
  }

  get whose(): Whose {
    return { run: this.run.id };
  }

  get period(): number {
    return this.run.period;
  }

  get home(): Range {
    return { from: 0, to: this.run.duration };
  }

  get extent(): Range {
    return this.home;
  }

  get window(): Range | null {
    const window = measuredWindow(this.run);
    return window && { from: window.start, to: window.end };
  }

  get source(): StillSource | null {
    return this.ofScopes.over(this.range);
  }

  override get overview() {
    const { whole } = this.ofScopes;
    return whole && { source: whole, range: this.home };
  }

  samples(columns: readonly string[], range: Range): Promise<StillSource | null> {
    return this.ofScopes.samples(columns, range);
  }

  get planeSource(): StillSource | null {
    return this.plane && this.ofPlane.over(this.plane);
  }

  get problem(): string {
    return this.ofScopes.problem || this.ofPlane.problem;
  }

  /** The moment that readings tell of: the last cursor, else under the pointer. */
  get moment(): number {
    return this.hover ?? this.cursors.at(-1) ?? Number.NaN;
  }

  /** Asks for curves of the part that is looked at. */
  load(): void {
    const { plane } = this;
    this.ofScopes.choose(this.columns);
    this.ofScopes.look(this.range);
    if (!plane) return;
    this.ofPlane.choose(planeColumns(this.run.variants));
    this.ofPlane.look(plane);
  }

  protected override looked(): void {
    this.load();
  }

  /** The scopes of a layout that ships; of this run, without one. */
  protected shipped(name: string): readonly ScopeSpec[] {
    const { run } = this;
    const layout = LAYOUTS.find((each) => each.name === name);
    const variant = run.variants.includes('B') ? 'B' : (run.variants[0] ?? '');
    return layout?.scopes(run.variants, { variant, axis: 'x' }) ?? errorScopes(run);
  }

  protected chosenPlane(): Range | null {
    return planeRange(this.run, this.zoom);
  }
}

function planeColumns(variants: readonly string[]): string[] {
  const references = AXES.map((axis) => `${axis}.position_reference`);
  const errors = variants
    .slice(0, 2)
    .flatMap((variant) => AXES.map((axis) => `${variant}.${axis}.following_error`));
  return [...references, ...errors];
}
