/** Changes of the running session while a control moves, sent one after the other. */

import { type Api, ApiError, UNREACHABLE } from '../api/client';
import type { Changes, Metrics, ProblemField, SessionInfo } from '../api/types';
import { LatestWins } from '../latest-wins';
import { Gestures } from './gestures';
import type { SessionStore } from './session.svelte';

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

export class LiveMetrics {
  /** null before there is a window to measure. */
  current = $state.raw<Metrics | null>(null);
  /** Of motions on drives that came before the present one, which has one variant. */
  private earlier: Metrics['variants'] = {};
  private readonly queue = new LatestWins<null>(() => this.ask());

  constructor(
    private readonly api: Api,
    private readonly session: SessionStore,
  ) {}

  /** Asks for the metrics of now; one question at a time, so that the newest answer stays. */
  read(): void {
    this.queue.push(null);
  }

  clear(earlier: Metrics['variants'] = {}): void {
    this.current = null;
    this.earlier = earlier;
  }

  private async ask(): Promise<void> {
    const { id } = this.session;
    // Before the first tick there is nothing to measure.
    if (id === '' || this.session.time === 0) {
      this.current = null;
      return;
    }
    try {
      const metrics = await this.api.metrics(id);
      if (id !== this.session.id) return;
      const variants = { ...this.earlier, ...metrics.variants };
      this.current = Object.keys(metrics.variants).length > 0 ? { ...metrics, variants } : null;
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      // Too early for a window. Without a server, what was measured last stays.
      if (error.status !== UNREACHABLE) this.current = null;
    }
  }
}
