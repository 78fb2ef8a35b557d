/** State and actions of the Identify screen. */

import { equal } from '../../app/api/scenario-paths';
import type {
  AxisIdentification,
  Axis,
  Changes,
  Identification,
  IdentificationPlan,
  Scenario,
} from '../../app/api/types';
import { AppliedChanges } from '../../parts/apply/applied-changes.svelte';
import { Comparison, forVariants } from '../../parts/apply/comparison.svelte';
import { fieldErrorsText } from '../../app/error-text';
import { inlineScenarioOf, wholeOf } from '../../app/jobs/job-request';
import { LatestWins } from '../../app/latest-wins';
import { fromAddress, load, save, setAddress } from '../../app/storage';
import { app, type Mode } from '../../app/store.svelte';
import { compensated, compensates, ExperimentForm, type Body } from './experiment-form.svelte';
import type { Friction, Points, CurveView } from './friction-curves';
import { parametersOf } from './parameter-rows';

/** What the request of a job holds as far as the page needs it. */
interface Asked {
  scenario: Scenario | string;
  set: Changes;
}

class Experiment {
  readonly form = new ExperimentForm('identify', {}, { variant: 0, apply_to: 1 });
  readonly job = this.form.jobOf('identify');
  readonly comparison = new Comparison(app.api, fieldErrorsText);
  /** Models that were given to the Lab, and whose. */
  readonly appliedChanges = new AppliedChanges();
  givenTo = $state.raw<readonly string[]>([]);
  plan = $state.raw<IdentificationPlan | null>(null);
  /** The axis that is looked at; null: the one that is at work, or the first. */
  private picked = $state<Axis | null>(null);
  view = $state<CurveView>(
    load('identify-view', 'signed' as string) === 'folded' ? 'folded' : 'signed',
  );
  showTrue = $state(load('identify-true', true));
  /** An earlier result beside the one that is looked at. */
  beside = $state.raw<{ id: string; result: Identification } | null>(null);
  private readonly plans = new LatestWins<Body>((body) => this.askPlan(body));

  readonly result = $derived(this.job.report?.result ?? null);
  private readonly partial = $derived(this.job.report?.partial ?? null);
  readonly standing = $derived(this.job.active ? (this.partial?.standing ?? null) : null);

  /** Axes of the job that is looked at, or of the plan before there is one. */
  readonly axes = $derived.by((): Axis[] => {
    const byAxis = this.result?.axes ?? (this.job.report ? {} : (this.plan?.record ?? {}));
    if (Object.keys(byAxis).length > 0) return Object.keys(byAxis) as Axis[];
    const requested = this.job.report?.request.axis;
    if (!this.job.report) return this.form.axes;
    return requested === 'x' || requested === 'y' ? [requested] : ['x', 'y'];
  });

  readonly axis = $derived.by((): Axis => {
    const [first = 'x'] = this.axes;
    const preferred = this.picked ?? (this.standing?.axis as Axis | null | undefined) ?? first;
    return this.axes.includes(preferred) ? preferred : first;
  });

  readonly identified = $derived(
    this.foundIn(this.result) ?? this.partial?.found[this.axis] ?? null,
  );
  readonly other = $derived(this.foundIn(this.beside?.result ?? null));

  readonly points = $derived.by(
    (): Points => this.identified?.points ?? this.partial?.axes[this.axis] ?? [],
  );

  /** Motions that are planned, or that are still to come. */
  readonly planned = $derived.by((): readonly { speed: number }[] => {
    const { report } = this.job;
    if (!report) return this.plan?.axes[this.axis] ?? [];
    if (!this.job.active || this.identified || report.request.run) return [];
    const speeds = (report.request.speeds ?? []) as readonly number[];
    const done = this.standing?.axis === this.axis ? this.standing.done : 0;
    return speeds.slice(done).map((speed) => ({ speed }));
  });

  readonly believed = $derived.by((): Friction | null => this.known('believed'));
  readonly true = $derived.by((): Friction | null => this.known('true'));

  readonly tooLong = $derived(
    this.plan !== null && this.plan.simulated_time > this.plan.simulated_time_max,
  );

  /** Settings in which the form differs from the job's request. */
  readonly settings = $derived.by((): readonly string[] => {
    const { report } = this.job;
    const { request: body } = this.form;
    if (!report || !body) return [];
    const names = this.form.differing(report.request, body);
    const then = inlineScenarioOf(report.request);
    const same = !then || equal(wholeOf(then, {}).plant, wholeOf(body, {}).plant);
    return same ? names : ['motor', ...names];
  });

  async open(): Promise<void> {
    await this.form.open(this.job);
    this.takeRecord();
  }

  /** Takes the run that another screen's link names, once. */
  private takeRecord(): void {
    const run = fromAddress('record');
    if (run === null) return;
    setAddress({ record: '' });
    this.form.readBy('run');
    this.readRun(run);
  }

  /** Reads another run, whose columns are its own. */
  readRun(run: string): void {
    this.form.reset(['record.variant', 'record.position_column', 'record.force_column']);
    this.form.change({ run });
  }

  pick(axis: Axis): void {
    this.picked = axis;
  }

  look(view: CurveView): void {
    this.view = view;
    save('identify-view', view);
  }

  /** Plans what the form says; nothing while a run is still to be chosen. */
  ask(body: Body | null): void {
    if (body) this.plans.push(body);
    else this.plan = null;
  }

  start(): Promise<void> {
    const { request } = this.form;
    return this.form.start(async () => {
      if (!request) return;
      this.picked = null;
      await this.job.start('/identify', request);
    });
  }

  /** Lays an earlier result beside the present one; an empty id takes it away. */
  async lay(id: string): Promise<void> {
    await app.try(async () => {
      const result = id === '' ? null : (await app.api.job<'identify'>(id)).result;
      this.beside = result ? { id, result } : null;
    });
  }

  /** Whether a comparison could differ at all. */
  readonly compares = $derived.by(() => {
    const source = this.source();
    if (!this.result || source === null || typeof source.scenario === 'string') return true;
    return compensates(source.scenario, source.set, this.result.apply_to);
  });

  /** The motor that old and new are judged on: of a run that which was fitted to it, where one was. */
  readonly judgedOn = $derived.by(() => {
    const { result } = this;
    if (!result) return '';
    return result.motor ? 'the motor fitted to the run' : `the simulated motor ${result.plant}`;
  });

  /** Runs the motion of the experiment with the old model (A) and the identified one (B). */
  async compare(): Promise<void> {
    const { result } = this;
    const source = this.source();
    if (!result || !source) return;
    await app.try(async () => {
      const { apply_to: variant, set: chosen, motor } = result;
      const own =
        typeof source.scenario === 'string'
          ? await app.api.scenario(source.scenario)
          : source.scenario;
      const scenario = motor ? { ...own, plant: motor.plant as Scenario['plant'] } : own;
      const labels = ['old model', 'identified'] as const;
      const others = Object.entries(source.set).filter(
        ([path]) => !motor || !/^plant\b/.test(path),
      );
      const set = compensated(scenario, Object.fromEntries(others), variant);
      this.comparison.run(result, { scenario, set, variant, chosen, labels });
    });
  }

  /** Gives what was identified to variants of the Lab. */
  apply(variants: readonly string[], mode: Mode): void {
    if (!this.result) return;
    this.appliedChanges.apply(forVariants(this.result.set, this.result.apply_to, variants), mode);
    this.givenTo = variants;
  }

  private source(): Asked | null {
    const request = this.job.report?.request as Partial<Asked> | undefined;
    return request ? { scenario: request.scenario ?? 'circle', set: request.set ?? {} } : null;
  }

  private foundIn(result: Identification | null): AxisIdentification | null {
    return result?.axes[this.axis] ?? null;
  }

  private known(which: 'believed' | 'true'): Friction | null {
    if (this.identified) {
      const entries = Object.entries(parametersOf(this.identified)).flatMap(([name, parameter]) => {
        const value = parameter[which];
        return value === null ? [] : [[name, value]];
      });
      // A motor without friction has a mass all the same.
      return entries.length > 1 ? (Object.fromEntries(entries) as Friction) : null;
    }
    const known = (this.job.report ? this.partial : this.plan)?.known;
    return known?.[this.axis]?.[which] ?? null;
  }

  private async askPlan(body: Body): Promise<void> {
    try {
      this.plan = await app.api.planIdentification(body);
      this.form.problems = {};
    } catch (error) {
      this.plan = null;
      this.form.refuse(error);
    }
  }
}

export const experiment = new Experiment();
