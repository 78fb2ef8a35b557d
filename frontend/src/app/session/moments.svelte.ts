/** When a session was pushed and when its parameters were changed. */

import type { SessionInfo } from '../api/types';

/** Control period, s. */
export const PERIOD = 0.0005;
/** Changes whose time is remembered. */
const CHANGES = 200;

export class Moments {
  pushes = $state.raw<readonly { time: number; label: string }[]>([]);
  /** Times at which parameters were changed, or a change undone, s. */
  changedAt = $state.raw<readonly number[]>([]);

  notePush(tick: number, label: string): void {
    this.pushes = [...this.pushes, { time: tick * PERIOD, label }];
  }

  /** An undo takes the change off the server's list: that it was, and when, is remembered here. */
  noteChanges(info: SessionInfo, before: SessionInfo | null): void {
    const same = before !== null && before.timeline === info.timeline;
    const undone = same && info.changes.length < before.changes.length;
    const ticks = [...info.changes.map(({ tick }) => tick), ...(undone ? [info.tick] : [])];
    const known = same ? this.changedAt : [];
    const times = ticks.map((tick) => tick * PERIOD).filter((time) => !known.includes(time));
    this.changedAt = [...known, ...times].slice(-CHANGES);
  }
}
