/** When a session was pushed and when its parameters were changed. */

import type { SessionInfo } from '../api/types';

/** Number of changes whose times are kept. */
const CHANGES = 200;

/** Moments of the same kind that follow each other within `gap`, s, as one, at the last of them. */
export function gathered(
  changes: readonly { time: number; set: object }[],
  gap: number,
): { time: number; set: object }[] {
  const moments: { time: number; set: object }[] = [];
  for (const { time, set } of changes) {
    const last = moments.at(-1);
    if (last && time - last.time < gap) {
      moments[moments.length - 1] = { time, set: { ...last.set, ...set } };
    } else moments.push({ time, set });
  }
  return moments;
}

/** A change of parameters, or that it was taken back. */
export interface Made {
  tick: number;
  set: object;
  undone: boolean;
}

export class Moments {
  /** Control period, s; 0 until the stream has sent it. */
  period = $state(0);
  private pushed = $state.raw<readonly { tick: number; label: string }[]>([]);
  private made = $state.raw<readonly Made[]>([]);

  readonly pushes = $derived(
    this.period === 0
      ? []
      : this.pushed.map(({ tick, label }) => ({ time: tick * this.period, label })),
  );
  /** Changes of parameters and their undoing, by time, s. */
  readonly changes = $derived(
    this.period === 0
      ? []
      : this.made.map(({ tick, set, undone }) => ({ time: tick * this.period, set, undone })),
  );

  notePush(tick: number, label: string): void {
    this.pushed = [...this.pushed, { tick, label }];
  }

  forgetPushes(): void {
    this.pushed = [];
  }

  /** An undo takes a change off the server's list: what happened is kept here, and the undo with it. */
  noteChanges(info: SessionInfo, before: SessionInfo | null): void {
    const same = before !== null && before.timeline === info.timeline;
    const known = same ? this.made : [];
    const fresh = info.changes
      .filter(({ tick, set }) => !known.some((each) => each.tick === tick && alike(each.set, set)))
      .map(({ tick, set }) => ({ tick, set, undone: false }));
    const gone = same ? before.changes.slice(info.changes.length) : [];
    const undone = gone.map(({ set }) => ({ tick: info.tick, set, undone: true }));
    this.made = [...known, ...fresh, ...undone].slice(-CHANGES);
  }
}

function alike(a: object, b: object): boolean {
  return JSON.stringify(a) === JSON.stringify(b);
}
