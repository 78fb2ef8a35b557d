/** State and actions of the Tune screen. */

import { at, equal } from '../../app/api/scenario-paths';
import type {
  Axis,
  Changes,
  MeasuredLoop,
  ReportOf,
  Scenario,
  TuneHistory,
} from '../../app/api/types';
import { AppliedChanges } from '../../parts/apply/applied-changes.svelte';
import { Comparison } from '../../parts/apply/comparison.svelte';
import { fieldErrorsText } from '../../app/error-text';
import { inlineScenarioOf, wholeOf } from '../../app/jobs/job-request';
import { JobStore } from '../../app/jobs/job-store.svelte';
import { load, save } from '../../app/storage';
import { app } from '../../app/store.svelte';
import {
  linesOf,
  machineLines,
  pickedLine,
  shapedLine,
  type CandidateLine,
  type Picked,
} from './candidates';
import { loopOf, LOOP, MAP, otherWords, type WhichLoop } from './job-differences';
import { costAt } from './landscape';
import { LoopStore } from './loop-store.svelte';
import { MachineTuning } from './machine-tuning.svelte';
import { ResponseForm } from './response-form.svelte';
import { ALSO_ON, SearchForm } from './search-form.svelte';

type Choice = Partial<Record<Axis, string>>;

class Tuner {
  readonly form = new SearchForm('tune', { plants: [ALSO_ON] }, { variant: 1 });
  readonly search = this.form.jobOf('tune');
  readonly map = this.form.jobOf('landscape');
  /** How the loop is measured. */
  readonly measuring = new ResponseForm();
  readonly measurement = new JobStore(app.api, 'response', (request) =>
    this.measuring.restore(request),
  );
  readonly shaping = new JobStore(app.api, 'shape');
  /** On what a loop is shaped: `simulated`, or a run by its identifier. */
  shapedOn = $state('simulated');
  /** The run that checks it; empty: none. */
  checkedBy = $state('');
  /** Largest factor of a gain, and most filters that are added. */
  step = $state(2);
  filters = $state(4);
  readonly machine = new MachineTuning(() => {
    const { source, variant, axis, margins } = this;
    return source && variant !== '' ? { source, variant, axis, margins } : null;
  });
  readonly loops = new LoopStore(app.api);
  readonly comparison = new Comparison(app.api, fieldErrorsText);
  /** Gains that were given to the Lab. */
  readonly appliedChanges = new AppliedChanges();
  private looked = $state<Axis>(load('tune-axis', 'x' as string) === 'y' ? 'y' : 'x');
  /** Which line of each axis is chosen, by its id. */
  private choice = $state.raw<Choice>({});
  picked = $state.raw<Partial<Record<Axis, Picked>>>({});

  readonly source = $derived(this.form.question);
  readonly scenario = $derived(this.form.scenario);
  readonly variant = $derived(this.form.controller);
  readonly axes = $derived(this.form.axes);
  readonly axis = $derived(this.axes.includes(this.looked) ? this.looked : (this.axes[0] ?? 'x'));

  readonly result = $derived(this.search.report?.result ?? null);

  readonly histories = $derived.by((): readonly TuneHistory[] => {
    const { report } = this.search;
    const groups = report?.result?.groups ?? report?.partial?.groups ?? [];
    return groups.find(({ axes }) => axes.includes(this.axis))?.starts ?? [];
  });

  readonly landscape = $derived.by(() => {
    const { report } = this.map;
    return (report?.result ?? report?.partial)?.axes[this.axis] ?? null;
  });

  readonly lines = $derived(this.linesFor(this.axis));

  readonly chosenId = $derived(this.chosenFor(this.axis));

  /** What the chosen lines of all axes put into the scenario, less what is there already. */
  readonly chosen = $derived.by((): Changes => {
    const set: Changes = {};
    for (const axis of this.axes) {
      const id = this.chosenFor(axis);
      if (id === 'present') continue;
      Object.assign(set, this.linesFor(axis).find((line) => line.id === id)?.set ?? {});
    }
    const entries = Object.entries(set).filter(
      ([path, value]) => !equal(at(this.scenario, path), value),
    );
    return Object.fromEntries(entries);
  });

  /** The chosen line of each axis, but where that is what is there. */
  readonly chosenLines = $derived(
    this.axes.flatMap((axis) => {
      const id = this.chosenFor(axis);
      return id === 'present' ? [] : [{ axis, id }];
    }),
  );

  /** The last measurement, of which of the two loops it is, and else why it is not drawn. */
  readonly measured = $derived.by(
    (): {
      loop: MeasuredLoop | null;
      of: WhichLoop;
      reason: string;
    } => {
      const { report } = this.measurement;
      const loop = report?.result ?? report?.partial ?? null;
      if (!report || !loop) return { loop: null, of: 'present', reason: '' };
      const none = (reason: string) => ({ loop: null, of: 'present' as const, reason });
      if (loop.axis !== this.axis || loop.variant !== this.variant) {
        return none(`of axis ${loop.axis} of controller ${loop.variant}`);
      }
      const then = this.askedFor(report.request);
      const now = this.now({});
      if (!then || !now) return none('asked for elsewhere');
      const chosen = this.loops.chosen ? this.now(this.chosen) : null;
      const { of, reason } = loopOf(then, now, chosen, this.variant);
      return of ? { loop, of, reason } : none(reason);
    },
  );

  /** What was proposed for this axis of this controller. */
  readonly shaped = $derived.by(() => {
    const result = this.shaping.report?.result ?? null;
    const { axis, variant } = result?.response ?? {};
    return axis === this.axis && variant === this.variant ? result : null;
  });

  /** In what that is not of what is tuned now; empty where it is, or is of a run. */
  readonly shapedOther = $derived.by(() => {
    const { report } = this.shaping;
    const now = this.now({});
    if (!this.shaped || !report || !now || this.shaped.response.run) return '';
    const then = this.askedFor(report.request);
    return then ? otherWords(then, now, this.variant, LOOP) : '';
  });

  /** In what the motion proposed for a machine is not of what is tuned now; empty where it is. */
  readonly machineOther = $derived.by(() => {
    const { shown } = this.machine;
    const now = this.now({});
    const then = shown && this.askedFor(shown.request);
    return then && now ? otherWords(then, now, this.variant, MAP) : '';
  });

  /** In what the cost map is not of what is tuned now; empty where it is. */
  readonly mapOther = $derived(this.landscape ? this.otherThan(this.map.report) : '');

  /** In what the last search was not of what is tuned now. */
  readonly searchOther = $derived(this.result ? this.otherThan(this.search.report) : '');

  /** Settings in which the form differs from the last search, and from the cost map. */
  readonly searchSettings = $derived.by(() =>
    this.source
      ? this.form.differing(this.search.report?.request, this.form.tuneBody(this.source))
      : [],
  );

  readonly mapSettings = $derived.by(() =>
    this.source
      ? this.form.differing(this.map.report?.request, this.form.landscapeBody(this.source))
      : [],
  );

  /** Whether the gains that a job began with are those that are there now. */
  readonly stale = $derived.by(() => {
    const present = this.result?.groups.flatMap((group) => Object.entries(group.present.set)) ?? [];
    return present.some(([path, value]) => {
      const now = at(this.scenario, path);
      return now !== null && now !== value; // null: the law decides
    });
  });

  open(): Promise<void> {
    const { search, map, measurement, shaping, machine } = this;
    return this.form.open(search, map, measurement, shaping, machine.job);
  }

  look(axis: Axis): void {
    this.looked = axis;
    save('tune-axis', axis);
  }

  take(id: string): void {
    this.choice = { ...this.choice, [this.axis]: id };
  }

  /** Takes gains off the landscape. */
  pick(k_p: number, k_d: number): void {
    const { axis, landscape } = this;
    const round = (value: number) => Number(value.toPrecision(4));
    const cost = landscape ? costAt(landscape, [k_p, k_d]) : null;
    const picked = { k_p: round(k_p), k_d: round(k_d), cost };
    this.picked = { ...this.picked, [axis]: picked };
    this.take('picked');
  }

  startSearch(): Promise<void> {
    this.choice = {};
    return this.form.start((question) => this.search.start('/tune', this.form.tuneBody(question)));
  }

  startMap(): Promise<void> {
    return this.form.start((question) =>
      this.map.start('/landscape', this.form.landscapeBody(question)),
    );
  }

  /** Measures the loop with the chosen gains. */
  async startMeasurement(): Promise<void> {
    const { source, variant, axis, chosen, measuring } = this;
    if (!source) return;
    measuring.problems = {};
    const set = { ...source.set, ...chosen };
    const body = { ...measuring.body(), scenario: source.scenario, set, variant, axis };
    try {
      await this.measurement.start('/response', body);
    } catch (error) {
      measuring.refuse(error);
    }
  }

  /** Proposes gains and filters on what is measured, which keep the limits of margins. */
  startShaping(): Promise<void> {
    const { variant, axis, shapedOn, checkedBy, step, filters } = this;
    const run = shapedOn === 'simulated' ? null : shapedOn;
    return this.form.start(({ scenario, set }) =>
      this.shaping.start('/shape', {
        scenario,
        set,
        variant,
        axis,
        step,
        filters,
        ...this.margins,
        ...(run === null ? {} : { run }),
        ...(run !== null && checkedBy !== '' ? { second_run: checkedBy } : {}),
      }),
    );
  }

  /** Runs the motion with the present gains and with the chosen ones. */
  compare(): void {
    const { source, variant, chosen } = this;
    if (!source) return;
    const labels = ['present gains', 'chosen gains'] as const;
    this.comparison.run(chosen, { ...source, variant, chosen, labels });
  }

  /** Least margins, where they are limited. */
  private get margins(): Readonly<Partial<Record<'gain_margin' | 'phase_margin', number>>> {
    const gain_margin = this.form.number('constraints.gain_margin');
    const phase_margin = this.form.number('constraints.phase_margin');
    return {
      ...(gain_margin === null ? {} : { gain_margin }),
      ...(phase_margin === null ? {} : { phase_margin }),
    };
  }

  /** Whether the Lab has the variant that was tuned. */
  readonly applicable = $derived(app.variants.includes(this.variant));

  private linesFor(axis: Axis): CandidateLine[] {
    const picked = this.picked[axis];
    const lines = linesOf(this.result?.groups ?? [], axis);
    const shaped = this.shaped?.response.axis === axis ? shapedLine(this.shaped) : null;
    const made = this.machine.of(axis);
    return [
      ...lines,
      ...(picked ? [pickedLine(picked, this.variant, axis)] : []),
      ...(shaped ? [shaped] : []),
      ...(made ? machineLines(made.document, made.metric) : []),
    ];
  }

  /** What was chosen by hand; else the best of a search that was asked for, if it is better. */
  private chosenFor(axis: Axis): string {
    const lines = this.linesFor(axis);
    const chosen = this.choice[axis];
    if (lines.some(({ id }) => id === chosen)) return chosen as string;
    if (this.search.report?.shipped) return 'present';
    const better = lines.find(
      ({ id, set }) =>
        id.startsWith('start') &&
        Object.keys(set).every((path) => path in (this.result?.set ?? {})),
    );
    return better?.id ?? 'present';
  }

  private askedFor(request: Record<string, unknown>): Scenario | null {
    const source = inlineScenarioOf(request);
    return source ? wholeOf(source, app.catalogue.resolved) : null;
  }

  /** The present scenario with changes. */
  private now(set: Changes): Scenario | null {
    const { source } = this;
    if (!source) return null;
    return wholeOf(
      { scenario: source.scenario, set: { ...source.set, ...set } },
      app.catalogue.resolved,
    );
  }

  private otherThan(report: ReportOf<'tune'> | ReportOf<'landscape'> | null): string {
    const now = this.now({});
    if (!report || !now) return '';
    const { request, result } = report;
    const then = this.askedFor(request);
    const variant = typeof request['variant'] === 'string' ? request['variant'] : this.variant;
    if (then) return otherWords(then, now, variant, MAP);
    // Requested elsewhere by a scenario's name: only the motor's name is there.
    return result && result.plant !== now.plant.name ? `another motor (${result.plant})` : '';
  }
}

export const tuner = new Tuner();
