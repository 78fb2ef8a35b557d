/** Undo and redo: states that are never changed in place, one for each gesture. */

const MOST = 500;
/** Steps of a gesture by keyboard that follow within this time are one, ms. */
const TOGETHER = 1000;

export class History<T> {
  private readonly past: T[] = [];
  private future: T[] = [];
  private gesture = '';
  private last = Number.NEGATIVE_INFINITY;

  get canUndo(): boolean {
    return this.past.length > 0;
  }

  get canRedo(): boolean {
    return this.future.length > 0;
  }

  /**
   * Keeps what was there before a change. Changes of one named gesture are one step: a drag until
   * its end, keys while they follow in quick succession. Without a name each is a step.
   */
  keep(before: T, gesture: string, now: number): void {
    const goesOn = gesture.startsWith('drag') || now - this.last < TOGETHER;
    const same = gesture !== '' && gesture === this.gesture && goesOn;
    this.gesture = gesture;
    this.last = now;
    this.future = [];
    if (same) return;
    this.past.push(before);
    if (this.past.length > MOST) this.past.shift();
  }

  /** Ends a gesture: the next change is a step of its own. */
  pause(): void {
    this.gesture = '';
  }

  undo(present: T): T {
    const before = this.past.pop();
    if (before === undefined) return present;
    this.future.push(present);
    this.pause();
    return before;
  }

  redo(present: T): T {
    const after = this.future.pop();
    if (after === undefined) return present;
    this.past.push(present);
    this.pause();
    return after;
  }
}
