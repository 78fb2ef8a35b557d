/** The drive link of the server as every screen sees it: its state, and STOP. */

import type { Api } from '../api/client';
import type { DriveStatus } from '../api/types';
import { LEASE, load } from '../storage';

/** Between two questions, ms: on the Drive screen, on others, and while the server is silent. */
const FAST = 200;
const SLOW = 1000;
/** Where this browser keeps the name under which others see what it does. */
export const NAME = 'drive-name';
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
  private followers = 0;

  constructor(private readonly api: Api) {}

  /** Whether torque is on, or on its way. */
  get torque(): boolean {
    return TORQUE.includes(this.status?.state ?? '');
  }

  start(linked: boolean): void {
    if (linked && this.linked === null) {
      void this.poll();
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
  }

  async stop(): Promise<void> {
    const query = { by: load(NAME, '') };
    if (this.linked) this.take(await this.api.json('post', '/drive/stop', { query }));
  }

  private async poll(): Promise<void> {
    for (;;) {
      if (!document.hidden) {
        try {
          this.take(await this.api.json('get', '/drive', {}));
        } catch (error) {
          this.silent = error instanceof Error ? error.message : String(error);
        }
      }
      const wait = this.followers > 0 && this.silent === '' ? FAST : SLOW;
      await new Promise((resolve) => setTimeout(resolve, wait));
    }
  }
}
