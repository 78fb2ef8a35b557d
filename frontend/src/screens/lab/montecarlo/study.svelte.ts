/** The Monte Carlo study of the Lab screen: its job, and whether it matches the controls. */

import { equal } from '../../../app/api/scenario-paths';
import { AXES, type Axis, type Changes, type MonteCarlo } from '../../../app/api/types';
import { inlineScenarioOf, wholeOf } from '../../../app/jobs/job-request';
import { load, oneOf, partOf, save } from '../../../app/storage';
import { app } from '../../../app/store.svelte';
import { ScenarioForm } from '../../../study/study-form.svelte';
import { stageRequest } from '../../../study/stage-request';
import { BandUnderlay } from '../../../plot/quantile-band';
import type { Scope } from '../../../plot/scope-catalog';
import type { SampleSource } from '../../../plot/source';
import type { Underlay } from '../../../plot/run-overlay';
import { covers, quantileBands, type Spec } from './spread';

export const CASES = [100, 300, 1000] as const;

export class Study extends ScenarioForm {
  readonly job = this.jobOf('monte-carlo');
  readonly cases = $derived(this.number('cases') ?? 300);
  /** Largest following error allowed, m. */
  spec = $state.raw<Spec>(load('montecarlo.spec', {}, partOf({ x: 0, y: 0 })));
  /** Whether the bands are drawn. */
  drawn = $state(load('montecarlo.drawn', true));
  /** Of the histogram: which metric of which axis. */
  metric = $state(load('montecarlo.metric', ''));
  axis = $state<Axis>(load('montecarlo.axis', 'x', oneOf('x', 'y')));
  readonly result = $derived<MonteCarlo | null>(this.job.report?.result ?? null);

  /** Whether the study is of another scenario or draft than the one that is shown. */
  readonly stale = $derived.by(() => this.otherThan(this.job.report?.request));
  readonly settings = $derived.by(() => this.differing(this.job.report?.request, this.body()));

  protected override get staged(): Changes {
    return app.draft;
  }

  /** Number of the plant of this study that the Lab shows; null where it shows another motor. */
  readonly opened = $derived.by((): number | null => {
    const { request } = this.job.report ?? {};
    const source = request && inlineScenarioOf(request);
    if (!source || !this.question || !this.stale) return null;
    const now = wholeOf(this.question, app.catalogue.resolved);
    const plant = this.result?.worst.find(({ set }) =>
      equal(
        wholeOf({ ...source, set: { ...source.set, ...(set as Changes) } }, app.catalogue.resolved),
        now,
      ),
    );
    return plant?.case ?? null;
  });

  private readonly bands = $derived.by((): Record<Axis, Underlay[]> | null => {
    const { result } = this;
    if (!result) return null;
    const of = (axis: Axis) => quantileBands(result, axis).map((band) => new BandUnderlay(band));
    return { x: of('x'), y: of('y') };
  });

  run(): Promise<void> {
    return this.start((question) =>
      this.job.start('/montecarlo', { ...question, cases: this.cases }),
    );
  }

  /** Stages the motor of one plant of the study, in the scenario that the study was asked for. */
  async openPlant({ set }: Pick<MonteCarlo['worst'][number], 'set'>): Promise<void> {
    await this.stage(set as Changes);
  }

  /** Stages what the study was asked for: the motor that its plants are drawn around. */
  async close(): Promise<void> {
    await this.stage({});
  }

  private async stage(drawn: Changes): Promise<void> {
    const { request } = this.job.report ?? {};
    if (request) await stageRequest(request, drawn);
  }

  look(at: { metric?: string; axis?: Axis }): void {
    if (at.metric !== undefined) save('montecarlo.metric', (this.metric = at.metric));
    if (at.axis) save('montecarlo.axis', (this.axis = at.axis));
  }

  setSpec(axis: Axis, limit: number | null): void {
    const others = Object.entries(this.spec).filter(([other]) => other !== axis);
    this.spec = Object.fromEntries(limit === null ? others : [...others, [axis, limit]]) as Spec;
    save('montecarlo.spec', this.spec);
  }

  setDrawn(drawn: boolean): void {
    this.drawn = drawn;
    save('montecarlo.drawn', drawn);
  }

  /** The bands behind a scope of what-if curves; none where they belong to other curves. */
  behind({ spec }: Scope, source: SampleSource | null): readonly Underlay[] {
    const axis = AXES.find((each) => spec.channels[0]?.endsWith(`.${each}.following_error`));
    if (!axis || !this.drawn || !this.bands || !source || app.mode !== 'whatif') return NONE;
    if (this.stale && this.opened === null) return NONE;
    const { start, end } = app.whatif.answer?.result.window ?? { start: 0, end: 0 };
    return covers(this.result?.time ?? [], start, end) ? this.bands[axis] : NONE;
  }
}

const NONE: readonly Underlay[] = [];

export const study = new Study('monte-carlo');
