/** The runs of a search, simulated again: their job, and whether it is shown. */

import { errorText } from '../../../app/error-text';
import { JobStore } from '../../../app/jobs/job-store.svelte';
import { app } from '../../../app/store.svelte';
import { replayRuns } from '../../../parts/runs/runs-api';
import { large } from '../playback/large.svelte';
import { runs } from '../runs.svelte';

class RunReplays {
  open = $state(false);
  /** Why the last request was refused. */
  problem = $state('');
  readonly job = new JobStore(app.api, 'replays', (request) => this.show(request));

  toggle(): void {
    this.open = !this.open;
    this.problem = '';
  }

  /** Finds the job again; one that runs is shown. */
  async resume(): Promise<void> {
    await this.job.resume();
    if (this.job.active) this.open = true;
  }

  /** Simulates the runs that are listed again. */
  async start(): Promise<void> {
    this.problem = '';
    try {
      await this.job.once(async () => this.job.follow(await replayRuns(runs.query.trim())));
    } catch (error) {
      this.problem = errorText(error);
    }
  }

  /** Lists the runs of a request. */
  private show({ q }: Record<string, unknown>): void {
    this.open = true;
    if (large.id !== '') large.close();
    if (typeof q === 'string' && q !== runs.query.trim()) runs.search(q);
  }
}

export const replays = new RunReplays();
