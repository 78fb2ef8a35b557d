/** The drive link of the server as every screen sees it: its state, its age, and STOP. */

import type { Api } from '../api/client';
import type { DriveStatus } from '../api/types';
import { RepeatedStop } from '../stop.svelte';
import { person } from '../session/person.svelte';
import { LEASE } from '../storage';

/** Between two questions, ms: on the Drive screen or with torque, and else. */
const FAST = 200;
const SLOW = 1000;
/** A question without an answer for this long, ms, is asked again. */
const ATTEMPT = 2000;
/** An answer older than this, ms, is not the state of now; the next look says so within a second. */
const MISSING = 800;
const TORQUE = ['arming', 'holding', 'moving', 'testing', 'stopping'];

export class DriveLink {
  /** Whether the server has a link; null until it has said so. */
  linked = $state<boolean | null>(null);
  /** The last answer; it stays while the server is silent. */
  status = $state.raw<DriveStatus | null>(null);
  /** When it came, ms of performance.now(). */
  at = $state(0);
  /** Why none has come since; empty when all is well. */
  silent = $state('');
  /** Time without an answer, s; 0 while all is well. */
  silence = $state(0);
  readonly halt = new RepeatedStop((signal) => this.sendStop(signal));
  private followers = 0;
  private shownAt = 0;

  constructor(private readonly api: Api) {}

  /** Whether torque is on, or on its way; of the last answer. */
  get torque(): boolean {
    return TORQUE.includes(this.status?.state ?? '');
  }

  /** Whether the last answer is the state of now. */
  get known(): boolean {
    return this.silent === '' && this.status !== null;
  }

  /** Whether the drives themselves have answered lately: what the last telegram says is true now. */
  get current(): boolean {
    return this.known && this.status?.known === true;
  }

  start(linked: boolean): void {
    if (linked && this.linked === null) {
      void this.poll();
      setInterval(() => this.look(), FAST);
      // The heartbeat of a tab that held control goes on after a reload, on any screen.
      if (sessionStorage.getItem(LEASE)) void import('./control.svelte');
    }
    this.linked = linked;
  }

  /** Asks more often until the returned function is called. */
  follow(): () => void {
    this.followers += 1;
    return () => (this.followers -= 1);
  }

  take(status: DriveStatus): void {
    this.status = status;
    this.at = performance.now();
    this.silent = '';
    this.silence = 0;
  }

  async stop(): Promise<void> {
    if (this.linked) await this.halt.press();
  }

  private async sendStop(signal: AbortSignal): Promise<void> {
    const query = { by: person.anywhere };
    this.take(await this.api.json('post', '/drive/stop', { query }, signal));
  }

  private get fast(): boolean {
    return this.followers > 0 || this.torque;
  }

  /** Notes how old the last answer is: a network that dies says so to no one. */
  private look(): void {
    const now = performance.now();
    if (document.hidden) this.shownAt = now; // it does not ask
    if (this.at === 0) return;
    const most = MISSING + (this.fast ? 0 : SLOW);
    const late = now - Math.max(this.at, this.shownAt) > most;
    if (late && this.silent === '') this.silent = 'The server does not answer.';
    this.silence = this.silent === '' ? 0 : (now - this.at) / 1000;
  }

  private async poll(): Promise<void> {
    for (;;) {
      if (!document.hidden) {
        try {
          this.take(await this.api.json('get', '/drive', {}, AbortSignal.timeout(ATTEMPT)));
        } catch (error) {
          this.silent = error instanceof Error ? error.message : String(error);
        }
      }
      const wait = this.fast ? FAST : SLOW;
      await new Promise((resolve) => setTimeout(resolve, wait));
    }
  }
}
