/** What-if: the scenario simulated anew while a control moves; the newest question wins. */

import { ApiError, type Api } from '../api/client';
import type { Changes, ProblemField, Scenario } from '../api/types';
import { errorText } from '../error-text';
import { LatestWins } from '../latest-wins';
import { Backoff } from '../stream/backoff';
import { readAnswer, type Preview } from './whatif-answer';

/** Bins of each curve while a control moves: more than a scope has pixels, and no more to carry. */
const COARSE = 1000;
/** Bins of the final curves: every tick of a window of 10 s, for zooming. */
const FINE = 20_000;
/** So long after the last question it counts as the last, ms. */
const REST = 200;
const TIMEOUT = 60_000;
/** Wait before a request to a busy or unreachable server is repeated, ms. */
const AGAIN = { first: 250, longest: 4000 };

export interface Question {
  scenario: Scenario;
  set: Changes;
  columns: string[];
}

interface Job {
  question: Question;
  points: number;
}

export interface Answered extends Preview {
  question: Question;
}

/**
 * `waiting`: nothing yet. `preview`: the curves precede the last change, or a control still moves.
 * `exact`: the curves are the result of the controls. `retrying`: the server is busy or out of
 * reach, and the last request is repeated; the curves are older. `failed`: the last request was
 * refused; the curves are older.
 */
export type WhatIfStatus = 'waiting' | 'preview' | 'exact' | 'retrying' | 'failed';

export class WhatIf {
  answer = $state.raw<Answered | null>(null);
  standing = $state<WhatIfStatus>('waiting');
  /** ms from question to answer, for the newest. */
  took = $state(0);
  /** Why the last request is repeated. */
  reason = $state('');
  private readonly queue = new LatestWins<Job>((job) => this.run(job));
  private rest: ReturnType<typeof setTimeout> | null = null;
  private again: ReturnType<typeof setTimeout> | null = null;
  private readonly backoff = new Backoff(AGAIN.first, AGAIN.longest);

  constructor(
    private readonly api: Api,
    private readonly refused: (fields: ProblemField[], detail: string) => void,
  ) {}

  /** Asks for curves soon, and for exact ones once the questions stop. */
  ask(question: Question): void {
    this.standing = 'preview';
    if (this.rest !== null) clearTimeout(this.rest);
    this.rest = setTimeout(() => {
      this.rest = null;
      this.push({ question, points: FINE });
    }, REST);
    this.push({ question, points: COARSE });
  }

  /** Queues a job, in place of one that waits for its repetition. */
  private push(job: Job): void {
    if (this.again !== null) clearTimeout(this.again);
    this.again = null;
    this.queue.push(job);
  }

  private async run(job: Job): Promise<void> {
    const { question, points } = job;
    const begin = performance.now();
    try {
      const signal = AbortSignal.timeout(TIMEOUT);
      const exact = points === FINE;
      const buffer = await this.api.whatif({ ...question, points, exact }, signal);
      this.answer = { ...readAnswer(buffer), question };
      if (!exact) this.took = performance.now() - begin;
      // Too long a scenario never runs from its start: its preview is final.
      if (exact && this.rest === null && !this.queue.superseded) this.standing = 'exact';
      this.backoff.reset();
      this.refused([], '');
    } catch (error) {
      // A newer question is on its way; its answer counts.
      if (this.queue.superseded) return;
      if (error instanceof ApiError && error.transient) {
        this.standing = 'retrying';
        this.reason = error.message;
        const wait = this.backoff.next();
        this.again = setTimeout(() => this.push(job), error.retryAfter ?? wait);
        return;
      }
      this.standing = 'failed';
      if (this.rest !== null) clearTimeout(this.rest);
      this.rest = null;
      if (error instanceof ApiError) this.refused(error.problem.errors, error.message);
      else this.refused([], errorText(error));
    }
  }
}
