/** What comes and goes must not make a button flicker: it counts once it has held for a while. */

import type { DriveStatus } from '../../app/api/types';

const HELD = 1000; // ms

/** Lets the exchange count as in phase once it has been so in every answer of the last second. */
export class SteadyPhase {
  private since = -Infinity;

  /** Returns a status that came at a time, ms, with the phase as it counts. */
  of(status: DriveStatus, at: number): DriveStatus {
    if (!status.loop.phase_locked) this.since = Infinity;
    else if (this.since > at) this.since = at;
    const steady = at - this.since >= HELD;
    if (steady === status.loop.phase_locked) return status;
    return { ...status, loop: { ...status.loop, phase_locked: steady } };
  }
}
