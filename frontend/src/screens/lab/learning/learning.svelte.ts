/** Learning from lap to lap, in the Lab: its job, and what becomes of what was learnt. */

import { at, equal } from '../../../app/api/scenario-paths';
import {
  AXES,
  type Axis,
  type Changes,
  type Learning,
  type LearntForce,
  type ProblemField,
} from '../../../app/api/types';
import { inlineScenarioOf, wholeOf } from '../../../app/jobs/job-request';
import { load, oneOf, save } from '../../../app/storage';
import { app } from '../../../app/store.svelte';
import { ScenarioForm } from '../../../study/study-form.svelte';
import { stageRequest } from '../../../study/stage-request';
import { diverges, DIVERGING, forgetting, type Laps, type Picture, PICTURES } from './laps';

/** Settings of which a job that ran anyway does not differ from the form. */
const ASKED = { anyway: false };

export class LearningForm extends ScenarioForm {
  readonly job = this.jobOf('learn');
  picture = $state<Picture>(load('learning.picture', 'laps', oneOf(...PICTURES)));
  /** Of the growth over frequency. */
  axis = $state<Axis>(load('learning.axis', 'y', oneOf(...AXES)));
  readonly result = $derived<Learning | null>(this.job.report?.result ?? null);
  /** Laps so far, by axis. */
  readonly laps = $derived.by((): Laps => {
    const { result } = this;
    if (!result) return this.job.report?.partial?.laps ?? {};
    return Object.fromEntries(Object.entries(result.axes).map(([axis, { laps }]) => [axis, laps]));
  });

  /** Whether the study is of another scenario or draft than the one that is shown. */
  readonly stale = $derived.by(() => this.otherThan(this.job.report?.request));
  readonly settings = $derived.by(() => {
    const { request } = this.job.report ?? {};
    return this.differing(request && { ...request, ...ASKED }, this.body());
  });

  /** Whether the Lab shows the scenario with what was learnt. */
  readonly used = $derived.by((): boolean => {
    const { request } = this.job.report ?? {};
    const source = request && inlineScenarioOf(request);
    if (!source || !this.question || !this.result) return false;
    const { resolved } = app.catalogue;
    const set = { ...source.set, ...(this.result.changes as Changes) };
    return equal(wholeOf({ ...source, set }, resolved), wholeOf(this.question, resolved));
  });

  /** The force that the scenario has, whoever learnt it. */
  readonly known = $derived.by(() => (app.scenario?.learnt ?? null) as LearntForce | null);
  /** Whether the server would learn if it had to. */
  readonly diverges = $derived.by(() => diverges(this.problems));

  /** One count of the encoder of the motor that learnt, m; NaN where it is not known. */
  readonly count = $derived.by((): number => {
    const { request } = this.job.report ?? {};
    const source = request && inlineScenarioOf(request);
    const whole = source ? wholeOf(source, app.catalogue.resolved) : null;
    return Math.min(...AXES.map((axis) => Number(at(whole, `plant.${axis}.encoder.resolution`))));
  });

  protected override get staged(): Changes {
    return app.draft;
  }

  override restore(request: Readonly<Record<string, unknown>>): void {
    super.restore({ ...request, ...ASKED });
  }

  /** The number would end a sentence that is about another one. */
  protected override refusal(problem: ProblemField): string {
    return super.refusal(
      problem.message.includes(DIVERGING) ? { ...problem, value: null } : problem,
    );
  }

  run(anyway: boolean): Promise<void> {
    const variant = this.text('variant');
    return this.start((question) =>
      this.job.start('/learn', { ...this.body(), ...question, variant, anyway }),
    );
  }

  /** Stages what was learnt, in the scenario that it was learnt of. */
  async use(): Promise<void> {
    const { request } = this.job.report ?? {};
    if (request && this.result) await stageRequest(request, this.result.changes as Changes);
  }

  /** Stages the scenario without its learnt force. */
  forget(): void {
    if (!app.scenario) return;
    app.setMode('whatif');
    app.set(forgetting(app.scenario));
  }

  look({ picture, axis }: { picture?: Picture; axis?: Axis }): void {
    if (picture) save('learning.picture', (this.picture = picture));
    if (axis) save('learning.axis', (this.axis = axis));
  }
}

export const learning = new LearningForm('learn', {}, { variant: 1 });
