/** Changes of the running session while a control moves, sent one after the other. */

import { ApiError } from '../api/client';
import type { Changes, ProblemField, SessionInfo } from '../api/types';
import { LatestWins } from '../latest-wins';
import { Gestures } from './gestures';

/** Shortest time between two changes of a running session while a slider moves, ms. */
const SPACING = 80;

export class LiveChanges {
  /** Those that the server has not confirmed. */
  unsent = $state.raw<Changes>({});
  private readonly gestures = new Gestures();
  /** Ends when every requested undo is done; nothing is sent meanwhile. */
  private undoing = Promise.resolve();
  private readonly queue = new LatestWins<null>(() => this.send());

  constructor(
    private readonly give: (set: Changes) => Promise<void>,
    private readonly refused: (fields: readonly ProblemField[], detail: string) => void,
  ) {}

  /** Takes values of a gesture that goes on, or of a new one. */
  put(changes: Changes, begins: boolean): void {
    this.gestures.put(changes, begins);
    this.unsent = this.gestures.unsent;
    this.queue.push(null);
  }

  /** Clears the changes of a session that was replaced. */
  clear(): void {
    this.gestures.clear();
  }

  /** Resolves when all has been sent. */
  async sent(): Promise<void> {
    while (this.queue.busy) await this.queue.idle();
  }

  /** Runs an undo once all has been sent. */
  async undo(run: () => Promise<void>): Promise<void> {
    await this.undoing;
    await this.sent();
    const undone = run();
    this.undoing = undone.catch(() => undefined);
    await undone;
  }

  /** Returns how many of a session's changes an undo takes back: a gesture's. */
  take(changes: SessionInfo['changes']): number {
    return Math.min(changes.length, this.gestures.take(changes));
  }

  private async send(): Promise<void> {
    await this.undoing;
    const sending = this.gestures.next();
    if (!sending) return;
    try {
      await this.give(sending.set);
      sending.taken();
    } catch (error) {
      if (error instanceof ApiError) this.refused(error.problem.errors, error.message);
      else throw error;
    } finally {
      sending.done();
      this.unsent = this.gestures.unsent;
    }
    await new Promise((resolve) => setTimeout(resolve, SPACING));
    if (this.gestures.next()) this.queue.push(null);
  }
}
