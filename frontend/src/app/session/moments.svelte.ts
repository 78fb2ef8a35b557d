/** When a session was pushed and when its parameters were changed. */

import type { SessionInfo } from '../api/types';

/** Number of changes whose times are kept. */
const CHANGES = 200;

/** Moments of the same kind that follow each other within `gap`, s, as one, at the last of them. */
export function gathered(
  changes: readonly { time: number; set: object }[],
  gap: number,
): { time: number; set: object }[] {
  const found: { time: number; set: object }[] = [];
  for (const { time, set } of changes) {
    const last = found.at(-1);
    if (last && time - last.time < gap) {
      found[found.length - 1] = { time, set: { ...last.set, ...set } };
    } else found.push({ time, set });
  }
  return found;
}

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
