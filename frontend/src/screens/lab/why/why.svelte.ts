/** The question why an error peaks, and its answer. */

import type { Changes, Why } from '../../../app/api/types';
import { LatestWins } from '../../../app/latest-wins';
import { app } from '../../../app/store.svelte';
import { marginLimits } from '../../../parts/loop/loops.svelte';
import { ScenarioForm } from '../../../study/study-form.svelte';

class WhyForm extends ScenarioForm {
  /** Whether the sheet is open. */
  shown = $state(false);
  answer = $state.raw<Why | null>(null);
  /** Whether an answer is on its way. */
  asking = $state(false);
  /** ms from question to answer. */
  took = $state(0);
  private readonly queue = new LatestWins<number | null>((time) => this.run(time));

  /** @param time - a moment near the peak, s; null: the largest of the metrics window */
  ask(time: number | null): void {
    this.asking = true;
    this.queue.push(time);
  }

  /** Stages the change that mends the peak. */
  stage(): void {
    const set = this.answer?.mend?.set;
    if (!set) return;
    app.setMode('whatif');
    app.set(set as Changes);
    this.shown = false;
  }

  private async run(time: number | null): Promise<void> {
    if (!this.question) return;
    const begin = performance.now();
    const limits = {
      gain_margin: marginLimits.of('gain_margin'),
      phase_margin: marginLimits.of('phase_margin'),
      Ms: marginLimits.of('Ms'),
    };
    const variant = this.text('variant');
    try {
      this.answer = await app.api.why({ ...this.body(), ...this.question, variant, time, limits });
      this.problems = {};
    } catch (error) {
      this.answer = null;
      this.refuse(error);
    }
    this.took = performance.now() - begin;
    this.asking = false;
  }
}

export const why = new WhyForm('why', {}, { variant: 1 });
