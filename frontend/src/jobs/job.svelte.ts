/**
 * A job of one kind as the page sees it: started, watched, cancelled, found again after a reload.
 *
 *   const job = new JobStore(lab.api, 'identify');
 *   await job.resume();                   // once, when its screen opens
 *   await job.start('/identify', body);   // an ApiError tells what is wrong with the body
 *   job.report?.partial, job.report?.result
 */

import { ApiError, UNREACHABLE, type Api } from '../api/client';
import type { JobKind, JobReport, JobSummary, ReportOf } from '../api/types';
import { load, save } from '../ui/storage';

const POLL = 250; // ms
const POLL_UNREACHABLE = 2000; // ms

export function active(job: Pick<JobReport, 'state'>): boolean {
  return job.state === 'queued' || job.state === 'running';
}

export class JobStore<K extends JobKind> {
  /** The job that is looked at. */
  report = $state.raw<ReportOf<K> | null>(null);
  /** Earlier jobs of the kind that are done, and those that run; the newest first. */
  records = $state.raw<readonly JobSummary[]>([]);
  reachable = $state(true);
  readonly active = $derived(this.report !== null && active(this.report));
  private watched = '';
  private asking = false;

  constructor(
    private readonly api: Api,
    readonly kind: K,
  ) {}

  /** Asks for a job in place of the present one; throws what the server has against it. */
  async start(path: string, body: object): Promise<void> {
    await this.once(async () => {
      this.follow(await this.api.start<K>(path, body));
    });
  }

  /** Does what asks for a job, unless that is on its way: a button is easily pressed twice. */
  async once(ask: () => Promise<void>): Promise<void> {
    if (this.asking) return;
    this.asking = true;
    try {
      await ask();
    } finally {
      this.asking = false;
    }
  }

  /** Looks at a job that was asked for elsewhere. */
  follow(report: ReportOf<K>): void {
    this.show(report);
    void this.watch();
  }

  async cancel(): Promise<void> {
    if (this.report) this.show(await this.api.cancelJob<K>(this.report.id));
    await this.list();
  }

  /** Looks at a job by its id. */
  async open(id: string): Promise<void> {
    this.follow(await this.api.job<K>(id));
  }

  /** Finds the job that was looked at, else one that runs, else the newest that is done. */
  async resume(): Promise<void> {
    await this.list();
    if (this.report) return;
    const ids = this.records.map(({ id }) => id);
    const kept = load(this.key, '');
    const id = this.records.find(active)?.id ?? (ids.includes(kept) ? kept : ids[0]);
    if (id === undefined) return;
    const report = await this.api.job<K>(id);
    // Meanwhile another may have been asked for; that one is looked at.
    if (!this.report) this.follow(report);
  }

  private get key(): string {
    return `job.${this.kind}`;
  }

  private async list(): Promise<void> {
    const jobs = await this.api.jobs(this.kind);
    this.records = jobs.filter((job) => active(job) || job.state === 'done');
  }

  private show(report: ReportOf<K>): void {
    this.report = report;
    save(this.key, report.id);
  }

  private async watch(): Promise<void> {
    const id = this.report?.id ?? '';
    if (!this.active || this.watched === id) return;
    this.watched = id;
    while (this.active && this.report?.id === id) {
      await new Promise((resolve) => setTimeout(resolve, this.reachable ? POLL : POLL_UNREACHABLE));
      await this.look(id);
    }
    if (this.watched === id) this.watched = '';
    await this.list().catch(() => undefined);
  }

  private async look(id: string): Promise<void> {
    try {
      const report = await this.api.job<K>(id);
      this.reachable = true;
      if (this.report?.id === id && this.active) this.show(report);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.reachable = error.status !== UNREACHABLE;
      if (error.status !== 404 || this.report?.id !== id) return;
      const gone = 'The server was started anew and has lost this job. Start it again.';
      this.report = { ...this.report, state: 'failed', error: gone };
    }
  }
}
