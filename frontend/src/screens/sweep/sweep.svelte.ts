/** The sweep of the Sweep screen: its swept fields beside the form of the study, and its job. */

import { ApiError } from '../../app/api/client';
import { equal } from '../../app/api/scenario-paths';
import type { Changes, SensitivityResult, SweepResult, Value } from '../../app/api/types';
import type { ScenarioSource } from '../../app/jobs/job-request';
import { load, oneOf, save } from '../../app/storage';
import { app } from '../../app/store.svelte';
import { stageRequest } from '../../study/stage-request';
import { ScenarioForm } from '../../study/study-form.svelte';
import { Criteria } from './criteria.svelte';
import { PLACES, type Place } from './figures';
import {
  casesOf,
  FIELDS_MAX,
  gridOf,
  isDrawn,
  KEPT,
  Refused,
  refusedFields,
  sweptFields,
  sweptOf,
} from './sweep-form';
import type { Problems, SweptField } from './sweep-form';
import { changesOf } from './sweep-result';

/** What is left out begins with these. */
const USUAL: Readonly<Record<string, number>> = { samples: 256, sampling_seed: 0 };
const FIRST = 'variants.B.controller.x.k_p';
const NEXT = [FIRST, FIRST.replace('k_p', 'k_d'), 'plant.x.mass', 'plant.y.mass', 'seed', 'plant'];

/** How a result is drawn: curves or a map, lines over parallel axes, two metrics, every number. */
export type View = 'picture' | 'parallel' | 'scatter' | 'numbers';

interface Shown {
  view: View;
  metric: string;
  /** The metric along x of a scatter. */
  against: string;
  axis: Place;
  variant: string;
}

const SHOWN: Shown = {
  view: 'picture',
  metric: 'max_abs_following_error',
  against: 'rms_force',
  axis: 'x',
  variant: 'B',
};

class Sweep extends ScenarioForm {
  readonly job = this.jobOf('sweep');
  readonly numbers = this.jobOf('sensitivity');
  readonly criteria = new Criteria(() => {
    this.problems = {};
  });
  private swept = $state.raw<readonly SweptField[]>(load('sweep.fields', [], KEPT));
  /** Which of the metrics is drawn. */
  shown = $state.raw<Shown>({
    ...SHOWN,
    ...load('sweep.shown', SHOWN, {
      view: oneOf('picture', 'parallel', 'scatter', 'numbers'),
      metric: '',
      against: '',
      axis: oneOf(...PLACES),
      variant: '',
    }),
  });
  /** The case that is looked at. */
  chosen = $state<number | null>(null);
  /** What is refused, by swept field. */
  refused = $state.raw<Problems>({});
  readonly result = $derived<SweepResult | null>(
    // Results of earlier versions have no objectives.
    this.job.report?.result
      ? { ...{ objectives: [], limits: [], front: [] }, ...this.job.report.result }
      : null,
  );
  readonly effects = $derived<SensitivityResult | null>(this.numbers.report?.result ?? null);

  readonly fields = $derived(
    this.swept.length > 0 || !this.scenario ? this.swept : [this.fresh(FIRST)],
  );

  readonly combine = $derived(this.text('combine') || 'grid');
  readonly drawn = $derived(isDrawn(this.combine));
  /** Number of cases; NaN while undefined. */
  readonly cases = $derived(
    this.drawn ? (this.number('samples') ?? Number.NaN) : casesOf(this.combine, this.fields),
  );

  /** Whether the result is of another scenario than the one that is shown now. */
  readonly stale = $derived.by(() => this.otherThan(this.job.report?.request));

  readonly numbersStale = $derived.by(() => this.otherThan(this.numbers.report?.request));

  readonly settings = $derived.by((): readonly string[] => {
    const { request } = this.job.report ?? {};
    if (!request) return [];
    const grid = (of: readonly SweptField[]) => {
      try {
        return gridOf(of, this.drawn);
      } catch {
        return of;
      }
    };
    const { objectives = [], limits = [] } = request as Record<string, unknown>;
    const same =
      this.differing(request, { ...request, ...this.combined }).length === 0 &&
      equal({ objectives, limits }, this.criteria.body()) &&
      equal(grid(sweptFields(request)), grid(this.fields));
    return same ? [] : ['swept fields'];
  });

  run(): Promise<void> {
    return this.start(async (question) => {
      const grid = gridOf(this.fields, this.drawn);
      const criteria = this.criteria.body();
      if (!criteria) return;
      await this.job.start('/sweep', {
        ...this.sourceOf(question),
        grid,
        ...criteria,
        ...this.combined,
      });
      this.chosen = null;
      if (this.drawn && this.shown.view === 'picture') this.show({ view: 'parallel' });
      if (this.shown.view === 'numbers') this.show({ view: this.drawn ? 'parallel' : 'picture' });
    });
  }

  /** Changes every number of the scenario. */
  runNumbers(): Promise<void> {
    return this.start(async (question) => {
      await this.numbers.start('/sensitivity', this.sourceOf(question));
      this.show({ view: 'numbers' });
    });
  }

  private sourceOf(question: ScenarioSource): ScenarioSource | { scenario: string } {
    return this.source === '' ? question : { scenario: this.source };
  }

  /** How values are combined, with what has an effect then. */
  private get combined() {
    const combine = this.combine as 'grid';
    if (!this.drawn) return { combine };
    const sampling_seed = this.number('sampling_seed') ?? 0;
    const drawn = { combine, samples: this.number('samples'), sampling_seed };
    if (this.combine !== 'search') return drawn;
    return { ...drawn, searcher: (this.text('searcher') || null) as 'tpe' | null };
  }

  /** Stages a case in the Lab. */
  async toLab(number: number): Promise<void> {
    const { result } = this;
    const { request } = this.job.report ?? {};
    if (result && request) await stageRequest(request, changesOf(result, number) as Changes);
  }

  protected override usual(path: string): Value {
    return path in USUAL ? (USUAL[path] as number) : super.usual(path);
  }

  override refuse(error: unknown): void {
    if (error instanceof Refused) this.refused = error.problems;
    else if (error instanceof ApiError && error.problem.errors.length > 0) {
      const { byField, others } = refusedFields(error.problem.errors);
      [this.refused, this.problems] = [byField, others.length > 0 ? { '': others.join(' ') } : {}];
    } else super.refuse(error);
  }

  override async choose(source: string): Promise<void> {
    if (source !== this.source) this.take([]);
    await super.choose(source);
  }

  override restore(request: Record<string, unknown>): void {
    super.restore(request);
    if (!('grid' in request)) return; // of every number: the fields stay
    const { scenario } = request;
    this.criteria.restore(request);
    void this.choose(typeof scenario === 'string' ? scenario : '');
    this.take(sweptFields(request));
  }

  edit(index: number, changes: Partial<SweptField>): void {
    const edited = (swept: SweptField): SweptField =>
      changes.path === undefined ? { ...swept, ...changes } : this.fresh(changes.path);
    this.take(this.fields.map((each, k) => (k === index ? edited(each) : each)));
  }

  /** Adds the next field: the gain of the other axis, or whatever is not swept yet. */
  add(): void {
    const path = NEXT.find((each) => !this.fields.some((field) => field.path === each));
    if (path !== undefined && this.fields.length < FIELDS_MAX) {
      this.take([...this.fields, this.fresh(path)]);
    }
  }

  /** Adds a field, or says in the form that it is there. */
  addField(path: string): void {
    const there = this.fields.some((field) => field.path === path);
    if (!there && this.fields.length < FIELDS_MAX) this.take([...this.fields, this.fresh(path)]);
  }

  remove(index: number): void {
    this.take(this.fields.filter((_, k) => k !== index));
  }

  show(changes: Partial<Shown>): void {
    this.shown = { ...this.shown, ...changes };
    save('sweep.shown', this.shown);
  }

  private take(fields: readonly SweptField[]): void {
    [this.swept, this.refused, this.problems] = [fields, {}, {}];
    save('sweep.fields', fields);
  }

  private fresh(path: string): SweptField {
    return sweptOf(
      path,
      this.scenario,
      app.catalogue.parts.motors.map(({ name }) => name),
    );
  }
}

export const sweep = new Sweep('sweep');
