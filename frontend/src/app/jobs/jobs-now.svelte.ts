/**
 * All jobs of the server that wait or run, and those of this visit that have ended.
 *
 * The server is due once a second while jobs run or the list is open, and once when the page is
 * opened or shown again.
 */

import type { Api } from '../api/client';
import type { JobState } from '../api/types';

const POLL = 1000; // ms
const POLL_UNREACHABLE = 5000; // ms

const goesOn = ({ state }: JobState): boolean => state === 'queued' || state === 'running';

class JobsNow {
  /** Those that wait or run, in order, then those that ended while the page was there. */
  jobs = $state.raw<readonly JobState[]>([]);
  reachable = $state(true);
  readonly active = $derived(this.jobs.filter(goesOn));
  readonly ended = $derived(this.jobs.filter((job) => !goesOn(job)));
  /** Share that is done of all that runs, 0 to 1. */
  readonly share = $derived(
    this.active.reduce((sum, { progress }) => sum + progress, 0) / Math.max(1, this.active.length),
  );
  private api: Api | null = null;
  /** Jobs of this visit: those that were seen to go on, or have come since the first answer. */
  private readonly seen = new Set<string>();
  /** Jobs that ended before this visit; null before the first answer. */
  private earlier: ReadonlySet<string> | null = null;
  private shown = false;
  private watching = false;
  private due = false;

  /** Begins to keep up; returns what ends that. */
  start(api: Api): () => void {
    this.api = api;
    this.earlier = null;
    const wake = () => void this.watch();
    document.addEventListener('visibilitychange', wake);
    wake();
    return () => {
      this.api = null;
      document.removeEventListener('visibilitychange', wake);
    };
  }

  /** Notes a job that this page follows. */
  note(id: string): void {
    this.seen.add(id);
    void this.watch();
  }

  /** Keeps up while the list is open. */
  show(shown: boolean): void {
    this.shown = shown;
    if (shown) void this.watch();
  }

  async stop({ id }: Pick<JobState, 'id'>): Promise<void> {
    await this.api?.cancelJob(id);
    void this.watch();
  }

  private async watch(): Promise<void> {
    this.due = true;
    if (this.watching) return;
    this.watching = true;
    while (this.api && !document.hidden && (this.due || this.shown || this.active.length > 0)) {
      this.due = false;
      await this.look(this.api);
      await new Promise((resolve) => setTimeout(resolve, this.reachable ? POLL : POLL_UNREACHABLE));
    }
    this.watching = false;
  }

  private async look(api: Api): Promise<void> {
    try {
      const jobs = await api.jobsNow();
      const { earlier } = this;
      // One may begin and end between two answers.
      const ours = jobs.filter((job) => goesOn(job) || (earlier && !earlier.has(job.id)));
      ours.forEach(({ id }) => this.seen.add(id));
      this.earlier ??= new Set(jobs.map(({ id }) => id));
      this.jobs = jobs.filter(({ id }) => this.seen.has(id));
      this.reachable = true;
    } catch {
      this.reachable = false;
    }
  }
}

export const jobsNow = new JobsNow();
