/**
 * Live changes by the gesture that makes them: a drag of a slider is one gesture, sends many changes
 * to the session, and is taken back by one undo.
 */

import { equal } from '../api/scenario-paths';
import type { Changes, SessionInfo } from '../api/types';

type Change = SessionInfo['changes'][number];

class Gesture {
  /** Values to be sent, and changes that the session has taken, the oldest first. */
  unsent: Changes = {};
  readonly sent: Changes[] = [];
}

/** A change that is on its way to the session. */
export interface Sending {
  readonly set: Changes;
  taken(): void;
  /** To be called at the end, taken or not. */
  done(): void;
}

export class Gestures {
  private list: Gesture[] = [];

  /** Values of all gestures that the session has not confirmed. */
  get unsent(): Changes {
    return Object.assign({}, ...this.list.map(({ unsent }) => unsent)) as Changes;
  }

  /** Takes values of a gesture that goes on, or of a new one. */
  put(changes: Changes, begins: boolean): void {
    if (begins || this.list.length === 0) this.list.push(new Gesture());
    const newest = this.list.at(-1) as Gesture;
    newest.unsent = { ...newest.unsent, ...changes };
  }

  /** Returns what is to be sent next: of one gesture only, the oldest that has something to send. */
  next(): Sending | null {
    const gesture = this.list.find(({ unsent }) => Object.keys(unsent).length > 0);
    if (!gesture) return null;
    const set = gesture.unsent;
    return {
      set,
      taken: () => gesture.sent.push(set),
      done: () => {
        const later = Object.entries(gesture.unsent).filter(([path, value]) => set[path] !== value);
        gesture.unsent = Object.fromEntries(later);
      },
    };
  }

  /**
   * Returns how many of a session's changes undo takes back: those of the newest gesture if they are
   * the last ones; else one, which came from elsewhere, such as another tab.
   */
  take(changes: readonly Change[]): number {
    for (;;) {
      const gesture = this.list.at(-1);
      if (!gesture) return 1;
      const count = trailing(gesture.sent, changes);
      const newest = gesture.sent.at(-1);
      const lies = newest !== undefined && changes.some((change) => is(change, newest));
      if (count === 0 && lies) return 1;
      this.list.pop();
      if (count > 0) return count;
    }
  }

  /** Clears the changes of a session that was replaced. */
  clear(): void {
    this.list = this.list.filter(({ unsent }) => Object.keys(unsent).length > 0);
    for (const { sent } of this.list) sent.length = 0;
  }
}

/** Number of the changes at the end of a list that were sent last. */
function trailing(sent: readonly Changes[], changes: readonly Change[]): number {
  let count = 0;
  while (count < sent.length) {
    const change = changes.at(-1 - count);
    if (!change || !is(change, sent.at(-1 - count) as Changes)) break;
    count += 1;
  }
  return count;
}

/** Whether a session's change is one that was sent; the server adds labels to it. */
export function is(change: Change, sent: Changes): boolean {
  return Object.entries(sent).every(([path, value]) => equal(change.set[path], value));
}
