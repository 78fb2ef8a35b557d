/** The sweep of the Sweep screen: request, job, and whether its result matches the form. */

import { ApiError } from '../../app/api/client';
import { equal, withChanges } from '../../app/api/scenario-paths';
import type { Axis, Scenario, SweepResult } from '../../app/api/types';
import { sourceOf, wholeOf, type ScenarioSource } from '../../app/jobs/job-request';
import { JobStore } from '../../app/jobs/job-store.svelte';
import { load, oneOf, save } from '../../app/storage';
import { app } from '../../app/store.svelte';
import { FIELDS_MAX, formOf, gridOf, KEPT, Refused, refusedFields, sweptOf } from './sweep-form';
import type { Problems, SweepForm, SweptField } from './sweep-form';

const FIRST = 'variants.B.controller.x.k_p';
const EMPTY: SweepForm = { source: '', combine: 'grid', fields: [] };

interface Shown {
  metric: string;
  axis: Axis;
  variant: string;
}

class Sweep {
  readonly job = new JobStore(app.api, 'sweep', (request) => void this.restore(request));
  form = $state.raw<SweepForm>(load('sweep', EMPTY, KEPT));
  /** Which of the metrics is drawn. */
  shown = $state.raw<Shown>(
    load(
      'sweep.shown',
      { metric: 'max_abs_following_error', axis: 'x', variant: 'B' },
      { metric: '', axis: oneOf('x', 'y'), variant: '' },
    ),
  );
  /** What is refused, by swept field, and of the request as a whole. */
  problems = $state.raw<Problems>({});
  refused = $state.raw<readonly string[]>([]);
  private named = $state.raw<Scenario | null>(null);
  readonly result = $derived<SweepResult | null>(this.job.report?.result ?? null);

  /** What is swept: a shipped scenario, or that of the Lab with its what-if changes. */
  readonly source = $derived.by((): ScenarioSource | null => {
    if (this.form.source !== '') return this.named ? { scenario: this.named, set: {} } : null;
    const scenario = app.session.info?.scenario;
    return scenario ? { scenario, set: app.mode === 'whatif' ? app.draft : {} } : null;
  });

  readonly scenario = $derived.by((): Scenario | null =>
    this.source ? withChanges(this.source.scenario, this.source.set, app.catalogue.resolved) : null,
  );

  readonly fields = $derived(
    this.form.fields.length > 0 || !this.scenario ? this.form.fields : [this.fresh(FIRST)],
  );

  /** Whether the result is of another scenario than the one that is shown now. */
  readonly stale = $derived.by(() => {
    const { request } = this.job.report ?? {};
    if (!request || !this.source) return false;
    const asked = sourceOf(request);
    if (!asked) return request.scenario !== this.form.source;
    const { resolved } = app.catalogue;
    return !equal(wholeOf(asked, resolved), wholeOf(this.source, resolved));
  });

  readonly settings = $derived.by((): readonly string[] => {
    const { request } = this.job.report ?? {};
    if (!request) return [];
    const { combine, fields } = formOf(request);
    const grid = (of: readonly SweptField[]) => {
      try {
        return gridOf(of);
      } catch {
        return of;
      }
    };
    const same = combine === this.form.combine && equal(grid(fields), grid(this.fields));
    return same ? [] : ['swept fields'];
  });

  async open(): Promise<void> {
    await this.readNamed();
    await app.try(() => this.job.resume());
  }

  async run(): Promise<void> {
    [this.problems, this.refused] = [{}, []];
    if (!this.source) return;
    try {
      const grid = gridOf(this.fields);
      const { source, combine } = this.form;
      const asked = source === '' ? this.source : { scenario: source };
      await this.job.start('/sweep', { ...asked, grid, combine });
    } catch (error) {
      if (error instanceof Refused) this.problems = error.problems;
      else if (error instanceof ApiError && error.problem.errors.length > 0) {
        const { byField, others } = refusedFields(error.problem.errors);
        [this.problems, this.refused] = [byField, others];
      } else await app.try(() => Promise.reject(error));
    }
  }

  async choose(source: string): Promise<void> {
    this.change({ source, fields: [] });
    await this.readNamed();
  }

  change(changes: Partial<SweepForm>): void {
    this.form = { ...this.form, fields: this.fields, ...changes };
    [this.problems, this.refused] = [{}, []];
    save('sweep', this.form);
  }

  edit(index: number, changes: Partial<SweptField>): void {
    const edited = (swept: SweptField): SweptField =>
      changes.path === undefined ? { ...swept, ...changes } : this.fresh(changes.path);
    this.change({ fields: this.fields.map((each, k) => (k === index ? edited(each) : each)) });
  }

  /** Adds the next field: the gain of the other axis, or whatever is not swept yet. */
  add(): void {
    if (this.fields.length >= FIELDS_MAX) return;
    const taken = new Set(this.fields.map(({ path }) => path));
    const path = [
      FIRST,
      FIRST.replace('k_p', 'k_d'),
      'plant.x.mass',
      'plant.y.mass',
      'seed',
      'plant',
    ].find((each) => !taken.has(each));
    if (path !== undefined) this.change({ fields: [...this.fields, this.fresh(path)] });
  }

  remove(index: number): void {
    this.change({ fields: this.fields.filter((_, k) => k !== index) });
  }

  show(changes: Partial<Shown>): void {
    this.shown = { ...this.shown, ...changes };
    save('sweep.shown', this.shown);
  }

  private fresh(path: string): SweptField {
    return sweptOf(
      path,
      this.scenario,
      app.catalogue.parts.motors.map(({ name }) => name),
    );
  }

  private async restore(request: Record<string, unknown>): Promise<void> {
    this.change(formOf(request));
    await this.readNamed();
  }

  private async readNamed(): Promise<void> {
    const { source } = this.form;
    if (source === '') return;
    await app.try(async () => {
      const scenario = await app.api.scenario(source);
      if (this.form.source === source) this.named = scenario;
    });
  }
}

export const sweep = new Sweep();
