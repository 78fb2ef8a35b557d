/** Largest stable value of each gain, requested when a control comes to rest. */

import type { Changes, Scenario } from '../../../app/api/types';
import { LatestWins } from '../../../app/latest-wins';
import { app } from '../../../app/store.svelte';
import { gainLimits } from './gains';

/** So long after the last change, ms. */
const REST = 250;

interface Question {
  scenario: Scenario;
  set: Changes;
}

class StabilityLimits {
  /** By the path of the gain; nothing for gains without a limit. */
  known = $state.raw<Readonly<Record<string, number>>>({});
  private readonly queue = new LatestWins<Question>((question) => this.run(question));
  private rest: ReturnType<typeof setTimeout> | null = null;

  ask(question: Question): void {
    if (this.rest !== null) clearTimeout(this.rest);
    this.rest = setTimeout(() => this.queue.push(question), REST);
  }

  private async run(question: Question): Promise<void> {
    try {
      this.known = gainLimits(await app.api.loop(question));
    } catch {
      this.known = {}; // The refusal is shown at its field.
    }
  }
}

export const stabilityLimits = new StabilityLimits();
