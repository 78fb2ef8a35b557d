/** The prediction of another law: its form, its job, and the run that both are of. */

import type { RunDetail } from '../../../app/api/types';
import { errorText } from '../../../app/error-text';
import { JobStore } from '../../../app/jobs/job-store.svelte';
import { load, save } from '../../../app/storage';
import { app } from '../../../app/store.svelte';
import { large } from '../playback/large.svelte';
import { runs } from '../runs.svelte';
import type { MinuteForm } from './minute';

const OPEN = 'minute';

class Minute {
  open = $state(load(OPEN, false));
  /** Why the last request was refused. */
  problem = $state('');
  /** The run whose section is to be scrolled to. */
  sought = $state('');
  readonly job = new JobStore(app.api, 'minute', (request) => this.show(request));
  private form = $state.raw<{ of: string; values: MinuteForm }>({ of: '', values: {} });

  toggle(): void {
    this.open = !this.open;
    save(OPEN, this.open);
  }

  /** What is entered for a run. */
  formOf({ id }: Pick<RunDetail, 'id'>): MinuteForm {
    return this.form.of === id ? this.form.values : {};
  }

  change(run: Pick<RunDetail, 'id'>, values: MinuteForm): void {
    this.form = { of: run.id, values: { ...this.formOf(run), ...values } };
    this.problem = '';
  }

  async predict(run: Pick<RunDetail, 'id'>): Promise<void> {
    this.problem = '';
    try {
      await this.job.start('/minute', { ...this.formOf(run), run: run.id });
    } catch (error) {
      this.problem = errorText(error);
    }
  }

  /** Shows the run of a request, with the request in its form. */
  private show(request: Record<string, unknown>): void {
    const { run, ...values } = request as MinuteForm & { run: string };
    this.form = { of: run, values };
    this.problem = '';
    this.open = true;
    this.sought = run;
    if (large.id !== '') large.close();
    runs.choose(run, 'only');
  }
}

export const minute = new Minute();
