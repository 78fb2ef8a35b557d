/** The moment that is shown while the pointer is elsewhere: it moves slowly through the range. */

import type { Range } from '../../../plot/range';

/** Wall-clock time for one way through the stretch, s. */
const WAY = 20;
/** Longest step, s: after a page that was hidden it goes on where it was. */
const STEP = 0.1;
/** Least time from one picture to the next, ms. */
const FRAME = 30;
/** Pitches by which the stator may pass from one picture to the next: more would seem to go back. */
const PASS = 0.2;

export class Playback {
  /** The moment at rest, s. */
  worst = 0;
  private time = Number.NaN;
  private since = 0;

  /**
   * Returns the moment to draw, s; null while it is too early for another picture. `pitches` is the
   * position at a moment, in pitches.
   */
  at(
    now: number,
    { pointed, range, moves }: { pointed: number | undefined; range: Range; moves: boolean },
    pitches: (time: number) => number,
  ): number | null {
    if (pointed !== undefined) {
      this.time = pointed;
      return pointed;
    }
    if (!moves) return this.worst;
    if (now < this.since + FRAME) return null;
    const passed = Math.min(STEP, (now - this.since) / 1000);
    this.since = now;
    if (!(this.time >= range.from && this.time < range.to)) this.time = range.from;
    let step = (passed * (range.to - range.from)) / WAY;
    const far = Math.abs(pitches(this.time + step) - pitches(this.time));
    if (far > PASS) step *= PASS / far;
    this.time += step;
    return this.time;
  }
}
