/** Offsets of whole laps, which lay a run of the same motion over another stretch of time. */

import { equal } from '../../app/api/scenario-paths';
import type { Range } from '../../plot/range';

export interface Motion {
  readonly kind?: unknown;
  readonly frequency?: unknown;
  readonly lead_in?: unknown;
}

interface Recorded {
  period: number;
  duration: number;
  /** When its first sample was, since the motion began, s. */
  begin: number;
  motion: Motion;
}

/** Figures of one frequency, all of whose laps are alike. */
const PERIODIC: readonly unknown[] = ['circle', 'sine'];
/** How often they go round, and how large they are, changes nothing of when they do what. */
const ANY = ['laps', 'cycles', 'for_ever', 'radius', 'amplitude', 'center'];
/** Of the numbers of laps that fit, as a share of one. */
const SLACK = 1e-6;

/** Returns the time of one lap of a motion that repeats, in whole control periods; null of others. */
export function lapTime({ kind, frequency }: Motion, period: number): number | null {
  if (!PERIODIC.includes(kind) || typeof frequency !== 'number' || !(frequency > 0)) return null;
  return Math.round(1 / frequency / period) * period;
}

/** Whether two motions are at the same place of their laps at all times. */
export function inStep(a: Motion, b: Motion): boolean {
  const timing = (motion: Motion) =>
    Object.fromEntries(Object.entries(motion).filter(([key]) => !ANY.includes(key)));
  return equal(timing(a), timing(b));
}

/**
 * Returns the offset by whole laps that lays a run over a stretch of time of a motion: its last laps, or
 * those after its lead-in where the stretch moves on; null where the motions differ, or nothing of the
 * run would be there.
 */
export function alignedOffset(
  { from, to }: Range,
  motion: Motion,
  run: Recorded,
  moving: boolean,
): number | null {
  const { period, duration, begin } = run;
  const lap = lapTime(motion, period);
  if (lap === null || !inStep(motion, run.motion)) return null;
  const leadIn = typeof motion.lead_in === 'number' ? motion.lead_in : lap / 2;
  const first = Math.ceil((to - begin - duration) / lap - SLACK);
  const last = Math.floor((from - Math.max(begin, leadIn)) / lap + SLACK);
  const laps = Math.max(0, moving ? Math.max(first, last) : first);
  const offset = Number((begin + laps * lap).toFixed(7));
  return offset < to && offset + duration > from ? offset : null;
}
