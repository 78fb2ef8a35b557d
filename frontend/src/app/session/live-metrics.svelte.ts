/** Metrics of the running session. */

import { ApiError, UNREACHABLE, type Api } from '../api/client';
import type { Metrics } from '../api/types';
import { LatestWins } from '../latest-wins';
import type { SessionStore } from './session.svelte';

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
