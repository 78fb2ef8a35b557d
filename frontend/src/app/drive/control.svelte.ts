/** Control over the drives: the lease with its heartbeat, and the commands that need it. */

import { ApiError, PATIENCE } from '../api/client';
import type { RequestOf } from '../api/operations';
import { messages } from '../messages.svelte';
import { person } from '../session/person.svelte';
import { LEASE } from '../storage';
import { app } from '../store.svelte';

/** Between two heartbeats, ms; the lease ends after 2 s without one. */
const BEAT = 500;
/** A heartbeat without an answer for this long, ms, gives its connection back. */
const ATTEMPT = 1000;

class DriveControl {
  private token = $state('');
  private timer: ReturnType<typeof setInterval> | undefined;
  private beating = false;

  constructor() {
    const kept = sessionStorage.getItem(LEASE);
    if (kept) this.hold(kept);
  }

  /** Whether this page holds control. */
  get held(): boolean {
    return this.token !== '';
  }

  async take(): Promise<void> {
    const body = { holder: person.anywhere };
    this.hold((await app.api.json('post', '/drive/lease', { body })).lease);
    await this.look();
  }

  /** Lets the holder know that this browser would like control. */
  async ask(): Promise<void> {
    await app.api.json('post', '/drive/lease/request', { body: { holder: person.anywhere } });
    await this.look();
  }

  /** Gives control up; the server stops armed drives first. */
  async giveUp(): Promise<void> {
    await app.api.json('delete', '/drive/lease', this.lease, AbortSignal.timeout(PATIENCE));
    this.drop();
    await this.look();
  }

  async arm(body: RequestOf<'/drive/arm'>): Promise<void> {
    app.drive.take(await app.api.json('post', '/drive/arm', { ...this.lease, body }));
  }

  async disarm(): Promise<void> {
    app.drive.take(
      await app.api.json('post', '/drive/disarm', this.lease, AbortSignal.timeout(PATIENCE)),
    );
  }

  /** Clears a latched fault, or brings the drives up again. */
  async reset(): Promise<void> {
    app.drive.take(await app.api.json('post', '/drive/reset', this.lease));
  }

  /** For other calls that need control. */
  get lease(): { header: { Lease: string } } {
    return { header: { Lease: this.token } };
  }

  private async look(): Promise<void> {
    app.drive.take(await app.api.json('get', '/drive', {}));
  }

  private hold(token: string): void {
    this.token = token;
    sessionStorage.setItem(LEASE, token);
    this.timer = setInterval(() => void this.beat(), BEAT);
    void this.beat();
  }

  private drop(): void {
    this.token = '';
    sessionStorage.removeItem(LEASE);
    clearInterval(this.timer);
  }

  private async beat(): Promise<void> {
    const { token } = this;
    if (this.beating) return;
    this.beating = true;
    try {
      await app.api.json('put', '/drive/lease', this.lease, AbortSignal.timeout(ATTEMPT));
    } catch (error) {
      // Out of reach for a moment: the next beat says whether the lease outlived it.
      if (!(error instanceof ApiError) || error.transient || token !== this.token) return;
      this.drop();
      messages.error(
        `Control of the drives was lost: ${error.message}. What moved was stopped. Take control again to go on.`,
      );
    } finally {
      this.beating = false;
    }
  }
}

export const control = new DriveControl();
