/** The comparison of friction models: its job, and why it was refused. */

import { errorText } from '../../app/error-text';
import type { Choice } from '../../app/api/types';
import { JobStore } from '../../app/jobs/job-store.svelte';
import { app } from '../../app/store.svelte';
import type { ModelsRequest } from './friction-models';

class FrictionModelsJob {
  /** Why the last request was refused. */
  problem = $state('');
  /** Effects of friction that may be compared too, and which are. */
  offered = $state.raw<readonly Choice[]>([]);
  effects = $state.raw<readonly string[]>([]);
  readonly job = new JobStore(app.api, 'friction-models');

  /** Asks once for the effects that the server has, those of the user's own files among them. */
  async open(): Promise<void> {
    if (this.offered.length > 0) return;
    try {
      this.offered = (await app.api.requestFields('friction-models')).effects?.choices ?? [];
    } catch (error) {
      this.problem = errorText(error);
    }
  }

  compare(effect: string, compared: boolean): void {
    const others = this.effects.filter((each) => each !== effect);
    this.effects = compared ? [...others, effect] : others;
  }

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
