/** The answer to the newest of some questions, and why there is none. */

import { errorText } from './error-text';
import { LatestWins } from './latest-wins';

export class LatestAnswer<Q, A> {
  answer = $state.raw<A | null>(null);
  problem = $state('');
  private readonly queue: LatestWins<Q>;

  constructor(ask: (question: Q) => Promise<A>) {
    this.queue = new LatestWins(async (question) => {
      try {
        [this.answer, this.problem] = [await ask(question), ''];
      } catch (error) {
        [this.answer, this.problem] = [null, errorText(error)];
      }
    });
  }

  push(question: Q): void {
    this.queue.push(question);
  }
}
