/** Tuning on a machine: the runs made so far, and the motion that is proposed next. */

import type { Axis, Changes, SafeTune } from '../../app/api/types';
import { inlineScenarioOf, type ScenarioSource } from '../../app/jobs/job-request';
import { JobStore } from '../../app/jobs/job-store.svelte';
import { messages } from '../../app/messages.svelte';
import { listOf, load, recordOf, save } from '../../app/storage';
import { app } from '../../app/store.svelte';
import { StudyForm } from '../../study/study-form.svelte';
import { isOf, rehearsedRows, runRows, type MadeRun } from './safe-tune';

/** What is tuned. */
interface Subject {
  source: ScenarioSource;
  variant: string;
  axis: Axis;
  margins: Readonly<Partial<Record<'gain_margin' | 'phase_margin', number>>>;
}

/** What a job has so far, where it is of an axis of the controller that is tuned. */
interface Shown {
  document: SafeTune;
  request: Readonly<Record<string, unknown>>;
  rehearsal: boolean;
  metric: 'peak' | 'rms';
}

/** Runs of motions, and those in which the loop was measured: one at most. */
interface Made {
  runs: readonly MadeRun[];
  response: readonly MadeRun[];
}

const NONE: Made = { runs: [], response: [] };
const KEY = 'tune-motions';
const RUN = { id: '', name: '' };
/** What a person enters; the rest of a request is what is tuned, and on what. */
export const FIELDS = ['metric', 'error', 'force', 'step', 'motions', 'measure'] as const;
/** The simulated machine, unless another is chosen: the fit to the paper's errors. */
const MACHINE = 'matched';

export class MachineTuning {
  readonly form = new StudyForm('safe-tune');
  readonly job = new JobStore(app.api, 'safe-tune', (request) => this.restore(request));
  /** Motor of the simulated machine; empty: the scenario's own. */
  plant = $state(MACHINE);
  simulating = $state(false);
  private made = $state.raw<Readonly<Record<string, Made>>>(
    load<Record<string, Made>>(KEY, {}, recordOf({ runs: listOf(RUN), response: listOf(RUN) })),
  );

  /** Of one motion, one controller and one axis. */
  private readonly key = $derived.by(() => {
    const { source, variant, axis } = this.subject() ?? {};
    return `${source?.scenario.name ?? ''}.${variant ?? ''}.${axis ?? ''}`;
  });
  readonly runs = $derived.by(() => (this.made[this.key] ?? NONE).runs);
  readonly response = $derived.by(() => (this.made[this.key] ?? NONE).response[0] ?? null);

  readonly shown = $derived.by(() => {
    const { axis } = this.subject() ?? {};
    return axis ? this.of(axis) : null;
  });

  readonly runRows = $derived.by(() =>
    runRows(this.runs, this.shown?.rehearsal === false ? this.shown.document : null),
  );
  readonly rehearsed = $derived.by(() =>
    this.shown?.rehearsal === true ? rehearsedRows(this.shown.document) : [],
  );
  /** Whether what is shown is of other runs than those that are listed. */
  readonly outdated = $derived.by(
    () => this.shown?.rehearsal === false && !isOf(this.runs, this.shown.document),
  );

  constructor(private readonly subject: () => Subject | null) {}

  /** What the job has of an axis. */
  of(axis: Axis): Shown | null {
    const { report } = this.job;
    const document = report?.result ?? report?.partial ?? null;
    const subject = this.subject();
    if (!report || !document || !subject) return null;
    const { request } = report;
    const { axis: its = 'x', variant = subject.variant, metric } = request;
    if (its !== axis || variant !== subject.variant) return null;
    const rehearsal = (request['machine'] ?? null) !== null;
    return { document, request, rehearsal, metric: metric === 'rms' ? 'rms' : 'peak' };
  }

  add(id: string, name: string): void {
    if (id === '' || this.runs.some((run) => run.id === id)) return;
    this.keep({ runs: [...this.runs, { id, name }] });
  }

  remove(id: string): void {
    this.keep({ runs: this.runs.filter((run) => run.id !== id) });
  }

  /** Takes the run in which margins are measured; without an identifier none. */
  measureIn(id: string, name: string): void {
    this.keep({ response: id === '' ? [] : [{ id, name }] });
  }

  /** Proposes the next motion from the runs made so far. */
  propose(): Promise<void> {
    const { runs, response } = this;
    return this.start({
      runs: runs.map(({ id }) => id),
      ...(response ? { response: response.id } : {}),
    });
  }

  /** Makes all motions on a simulated machine. */
  rehearse(): Promise<void> {
    return this.start({ machine: this.machine });
  }

  /** Simulates the proposed motion, keeps it as a run and lists that. */
  async simulate(): Promise<void> {
    const { shown, job, runs, machine } = this;
    const { proposal } = shown?.document ?? {};
    const source = job.report && (inlineScenarioOf(job.report.request) ?? this.subject()?.source);
    if (!proposal || !source || this.simulating) return;
    this.simulating = true;
    await app.try(async () => {
      const { scenario, set } = source;
      const name = `motion ${String(runs.length + 1)} of tuning, ${scenario.name}`;
      const body = {
        scenario,
        set: { ...set, ...(proposal.changes as Changes), ...machine },
        keep: true,
        name,
      };
      const answer = await app.api.json('post', '/simulate', { body });
      if ('run' in answer && answer.run) this.add(answer.run, name);
      else messages.info(`It takes long: add “${name}” when it is done.`);
    });
    this.simulating = false;
  }

  private get machine(): Changes {
    return this.plant === '' ? {} : { plant: this.plant };
  }

  private async start(motions: object): Promise<void> {
    const subject = this.subject();
    if (!subject) return;
    this.form.problems = {};
    const { source, variant, axis, margins } = subject;
    const entered = Object.entries(this.form.body()).filter(([name]) =>
      (FIELDS as readonly string[]).includes(name),
    );
    const { scenario, set } = source;
    const body = { scenario, set, variant, axis, ...margins, ...Object.fromEntries(entered) };
    try {
      await this.job.start('/safe-tune', { ...body, ...motions });
    } catch (error) {
      this.form.refuse(error);
    }
  }

  /** Takes the runs and numbers of an earlier request. */
  private restore(request: Readonly<Record<string, unknown>>): void {
    const fields = FIELDS.filter((name) => name in request && request[name] !== null);
    this.form.restore(Object.fromEntries(fields.map((name) => [name, request[name]])));
    const { runs = [], response, machine } = request;
    if ((machine ?? null) !== null) return;
    const named = (id: string) => this.runs.find((run) => run.id === id) ?? { id, name: id };
    this.keep({
      runs: (runs as readonly string[]).map(named),
      response: typeof response === 'string' ? [named(response)] : [],
    });
  }

  private keep(made: Partial<Made>): void {
    const now = this.made[this.key] ?? NONE;
    this.made = { ...this.made, [this.key]: { ...now, ...made } };
    save(KEY, this.made);
  }
}
