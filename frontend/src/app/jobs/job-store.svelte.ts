/**
 * A job of one kind in the page: started, watched, cancelled, found again after a reload.
 *
 * Jobs that this browser has started are found by themselves. A screen that has a shipped result
 * begins with the latest of anybody, or with that one; other jobs are listed to choose from.
 *
 *   const job = new JobStore(app.api, 'identify');
 *   await job.resume();                   // once, when its screen opens
 *   await job.start('/identify', body);   // an ApiError names what is wrong with the body
 *   job.report?.partial, job.report?.result
 */

import { ApiError, type Api, type StudyPath } from '../api/client';
import type { RequestOf } from '../api/operations';
import type { JobKind, JobReport, JobSummary, ReportOf } from '../api/types';
import { listOf, load, save } from '../storage';
import { jobsNow } from './jobs-now.svelte';
import { opensJobs } from './open-job';

/** Ids kept of each kind; the server keeps fewer records. */
const OWN_MAX = 200;
const POLL = 250; // ms
const POLL_UNREACHABLE = 2000; // ms
const LISTED: readonly string[] = ['done', 'interrupted'];

export function active(job: Pick<JobReport, 'state'>): boolean {
  return job.state === 'queued' || job.state === 'running';
}

/** What is seen and done of a job of any kind. */
export type WatchedJob = { readonly report: JobReport | null } & Pick<
  JobStore<JobKind>,
  'active' | 'reachable' | 'records' | 'otherModel' | 'isOwn' | 'cancel' | 'open' | 'showRequest'
>;

export class JobStore<K extends JobKind> {
  /** The job that is looked at. */
  report = $state.raw<ReportOf<K> | null>(null);
  /** Jobs of the kind that are done, run or were interrupted; the newest first. */
  records = $state.raw<readonly JobSummary[]>([]);
  reachable = $state(true);
  readonly active = $derived(this.report !== null && active(this.report));
  /** Whether what is shown was computed with another version of the model. */
  readonly otherModel = $derived.by(
    () => this.records.find(({ id }) => id === this.report?.id)?.other_model === true,
  );
  private watched = '';
  private asking = false;

  /** @param restore puts a job's request into its form, once the user chooses that job */
  constructor(
    private readonly api: Api,
    readonly kind: K,
    private readonly restore: (request: Record<string, unknown>) => void = () => undefined,
  ) {}

  /** Asks for a job in place of the present one; throws what the server has against it. */
  async start<P extends StudyPath>(path: P, body: RequestOf<P>): Promise<void> {
    await this.once(async () => {
      this.follow(await this.api.start<K, P>(path, body));
    });
  }

  /** Runs a request for a job, unless one is on its way: a button is easily pressed twice. */
  async once(ask: () => Promise<void>): Promise<void> {
    if (this.asking) return;
    this.asking = true;
    try {
      await ask();
    } finally {
      this.asking = false;
    }
  }

  /** Shows a job that this browser has just started. */
  follow(report: ReportOf<K>): void {
    const others = this.own.filter((id) => id !== report.id);
    save(this.ownKey, [report.id, ...others].slice(0, OWN_MAX));
    this.look(report);
  }

  /** Whether this browser has started a job. */
  isOwn({ id }: Pick<JobSummary, 'id'>): boolean {
    return this.own.includes(id);
  }

  async cancel(): Promise<void> {
    if (this.report) this.show(await this.api.cancelJob<K>(this.report.id));
    await this.list();
  }

  /** Shows a job that the user has chosen, and its request in its form. */
  async open(id: string): Promise<void> {
    this.look(await this.api.job<K>(id));
    this.showRequest();
  }

  /** Puts the request of the job that is looked at into its form. */
  showRequest(): void {
    if (this.report) this.restore(this.report.request);
  }

  /**
   * Finds one of this browser's own jobs that runs, else the job that was looked at, else the newest
   * of its own that is done or was interrupted; else, of a kind with a shipped result, the newest of
   * the server or that one.
   */
  async resume(): Promise<void> {
    await opensJobs(this.kind, this);
    await this.list();
    if (this.report) return;
    const { own, records } = this;
    const ours = records.filter(({ id }) => own.includes(id));
    const kept = load(this.key, '');
    const ships = records.some(({ shipped }) => shipped);
    const resumed =
      ours.find(active) ??
      records.find(({ id }) => id === kept) ??
      ours[0] ??
      (ships ? records.find(({ state }) => state === 'done') : undefined);
    if (!resumed) return;
    const report = await this.api.job<K>(resumed.id);
    // Meanwhile another may have been started; that one is shown.
    if (!this.report) this.look(report);
  }

  private get key(): string {
    return `job.${this.kind}`;
  }

  private get ownKey(): string {
    return `jobs.${this.kind}`;
  }

  /** Ids of jobs that this browser has started, the newest first; other tabs add theirs. */
  private get own(): readonly string[] {
    return load<readonly string[]>(this.ownKey, [], listOf(''));
  }

  private async list(): Promise<void> {
    const jobs = await this.api.jobs(this.kind);
    this.records = jobs.filter((job) => active(job) || LISTED.includes(job.state));
  }

  private look(report: ReportOf<K>): void {
    this.show(report);
    void this.watch();
  }

  private show(report: ReportOf<K>): void {
    this.report = report;
    // What comes with the program gives way to whatever is computed.
    if (!report.shipped) save(this.key, report.id);
  }

  private async watch(): Promise<void> {
    const id = this.report?.id ?? '';
    if (!this.active || this.watched === id) return;
    this.watched = id;
    jobsNow.note(id);
    while (this.active && this.report?.id === id) {
      await new Promise((resolve) => setTimeout(resolve, this.reachable ? POLL : POLL_UNREACHABLE));
      await this.poll(id);
    }
    if (this.watched === id) this.watched = '';
    await this.list().catch(() => undefined);
  }

  /** Polls the job once. Polling continues after any failure, as does the job. */
  private async poll(id: string): Promise<void> {
    try {
      const report = await this.api.job<K>(id);
      this.reachable = true;
      if (this.report?.id === id && this.active) this.show(report);
    } catch (error) {
      const unknown = error instanceof ApiError && error.status === 404;
      this.reachable = unknown;
      if (!unknown || this.report?.id !== id) return;
      const gone = 'The server was started anew and has lost this job. Start it again.';
      this.report = { ...this.report, state: 'failed', error: gone };
    }
  }
}
