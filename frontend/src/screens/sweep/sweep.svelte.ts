/** The sweep of the Sweep screen: its swept fields beside the form of the study, and its job. */

import { ApiError } from '../../app/api/client';
import { equal } from '../../app/api/scenario-paths';
import type { Axis, SweepResult } from '../../app/api/types';
import { load, oneOf, save } from '../../app/storage';
import { app } from '../../app/store.svelte';
import { ScenarioForm } from '../../study/study-form.svelte';
import {
  FIELDS_MAX,
  gridOf,
  KEPT,
  Refused,
  refusedFields,
  sweptFields,
  sweptOf,
} from './sweep-form';
import type { Problems, SweptField } from './sweep-form';

const FIRST = 'variants.B.controller.x.k_p';
const NEXT = [FIRST, FIRST.replace('k_p', 'k_d'), 'plant.x.mass', 'plant.y.mass', 'seed', 'plant'];

interface Shown {
  metric: string;
  axis: Axis;
  variant: string;
}

class Sweep extends ScenarioForm {
  readonly job = this.jobOf('sweep');
  private chosen = $state.raw<readonly SweptField[]>(load('sweep.fields', [], KEPT));
  /** Which of the metrics is drawn. */
  shown = $state.raw<Shown>(
    load(
      'sweep.shown',
      { metric: 'max_abs_following_error', axis: 'x', variant: 'B' },
      { metric: '', axis: oneOf('x', 'y'), variant: '' },
    ),
  );
  /** What is refused, by swept field. */
  refused = $state.raw<Problems>({});
  readonly result = $derived<SweepResult | null>(this.job.report?.result ?? null);

  readonly fields = $derived(
    this.chosen.length > 0 || !this.scenario ? this.chosen : [this.fresh(FIRST)],
  );

  /** Whether the result is of another scenario than the one that is shown now. */
  readonly stale = $derived.by(() => this.otherThan(this.job.report?.request));

  readonly settings = $derived.by((): readonly string[] => {
    const { request } = this.job.report ?? {};
    if (!request) return [];
    const grid = (of: readonly SweptField[]) => {
      try {
        return gridOf(of);
      } catch {
        return of;
      }
    };
    const same =
      this.differing(request, { ...request, ...this.body() }).length === 0 &&
      equal(grid(sweptFields(request)), grid(this.fields));
    return same ? [] : ['swept fields'];
  });

  run(): Promise<void> {
    return this.start(async (question) => {
      const grid = gridOf(this.fields);
      const scenario = this.source === '' ? question : { scenario: this.source };
      const combine = this.text('combine') === 'list' ? 'list' : 'grid';
      await this.job.start('/sweep', { ...scenario, grid, combine });
    });
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
    const { scenario } = request;
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

  remove(index: number): void {
    this.take(this.fields.filter((_, k) => k !== index));
  }

  show(changes: Partial<Shown>): void {
    this.shown = { ...this.shown, ...changes };
    save('sweep.shown', this.shown);
  }

  private take(fields: readonly SweptField[]): void {
    [this.chosen, this.refused, this.problems] = [fields, {}, {}];
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
