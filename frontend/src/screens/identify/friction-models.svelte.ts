/** The comparison of friction models: its job, and why it was refused. */

import { errorText } from '../../app/error-text';
import { JobStore } from '../../app/jobs/job-store.svelte';
import { app } from '../../app/store.svelte';
import type { ModelsRequest } from './friction-models';

class FrictionModelsJob {
  /** Why the last request was refused. */
  problem = $state('');
  readonly job = new JobStore(app.api, 'friction-models');

  async start(request: ModelsRequest): Promise<void> {
    this.problem = '';
    try {
      await this.job.start('/friction-models', request);
    } catch (error) {
      this.problem = errorText(error);
    }
  }
}

export const frictionModels = new FrictionModelsJob();
