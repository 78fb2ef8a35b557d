/** When a session was pushed and when its parameters were changed. */

import type { SessionInfo } from '../api/types';

/** Number of changes whose times are kept. */
const CHANGES = 200;

export class Moments {
  /** Control period, s; 0 until the stream has sent it. */
  period = $state(0);
  private pushed = $state.raw<readonly { tick: number; label: string }[]>([]);
  private changed = $state.raw<readonly number[]>([]);

  readonly pushes = $derived(
    this.period === 0
      ? []
      : this.pushed.map(({ tick, label }) => ({ time: tick * this.period, label })),
  );
  /** Times at which parameters were changed, or a change undone, s. */
  readonly changedAt = $derived(
    this.period === 0 ? [] : this.changed.map((tick) => tick * this.period),
  );

  notePush(tick: number, label: string): void {
    this.pushed = [...this.pushed, { tick, label }];
  }

  forgetPushes(): void {
    this.pushed = [];
  }

  /** An undo takes the change off the server's list: its time is kept here. */
  noteChanges(info: SessionInfo, before: SessionInfo | null): void {
    const same = before !== null && before.timeline === info.timeline;
    const undone = same && info.changes.length < before.changes.length;
    const ticks = [...info.changes.map(({ tick }) => tick), ...(undone ? [info.tick] : [])];
    const known = same ? this.changed : [];
    this.changed = [...known, ...ticks.filter((tick) => !known.includes(tick))].slice(-CHANGES);
  }
}
