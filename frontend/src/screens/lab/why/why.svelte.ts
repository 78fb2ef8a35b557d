/** The question why an error peaks, and its answer. */

import type { Axis, Changes, Why } from '../../../app/api/types';
import { errorText } from '../../../app/error-text';
import { LatestWins } from '../../../app/latest-wins';
import { marginLimits } from '../../../parts/loop/margin-limits.svelte';
import { app } from '../../../app/store.svelte';

export interface WhyQuestion {
  variant: string;
  /** null: the axis on which the error is largest. */
  axis: Axis | null;
  /** A moment near the peak, s; null: the largest of the metrics window. */
  time: number | null;
  /** m; null: half the peak. */
  goal: number | null;
}

class WhyStore {
  open = $state(false);
  /** Whose error; empty for the second variant, or the only one. */
  variant = $state('');
  axis = $state<Axis | 'worse'>('worse');
  answer = $state.raw<Why | null>(null);
  problem = $state('');
  asking = $state(false);
  /** ms from question to answer. */
  took = $state(0);
  private readonly queue = new LatestWins<WhyQuestion>((question) => this.run(question));

  ask(question: WhyQuestion): void {
    this.asking = true;
    this.queue.push(question);
  }

  /** Stages the change that mends the peak. */
  stage(): void {
    const set = this.answer?.mend?.set;
    if (!set) return;
    app.setMode('whatif');
    app.set(set as Changes);
    this.open = false;
  }

  private async run(question: WhyQuestion): Promise<void> {
    const scenario = app.session.info?.scenario;
    if (!scenario) return;
    const begin = performance.now();
    const limits = {
      gain_margin: marginLimits.of('gain_margin'),
      phase_margin: marginLimits.of('phase_margin'),
      Ms: marginLimits.of('Ms'),
    };
    const set = app.mode === 'whatif' ? app.draft : {};
    try {
      this.answer = await app.api.why({ ...question, scenario, set, limits });
      this.problem = '';
    } catch (error) {
      this.answer = null;
      this.problem = errorText(error);
    }
    this.took = performance.now() - begin;
    this.asking = false;
  }
}

export const why = new WhyStore();
