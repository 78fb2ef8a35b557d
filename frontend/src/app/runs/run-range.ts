/** Which samples of a run are read for a stretch of time. */

import type { Range } from '../../plot/source';
import type { RunDetail } from '../api/types';
import { covers, within, type Grid } from './seen-curves';

export type Length = Pick<RunDetail, 'ticks' | 'period' | 'duration'>;

/** Bins across what is visible: more than a scope has pixels; with fewer it is read again. */
export const BINS = 2000;
const LEAST_BINS = 1000;
/** Bins of an answer that has every sample: 250 s of them. */
export const EVERY = 500_000;
/** Most that one answer may have that is drawn. */
const BINS_MAX = 20_000;
/** Read beyond what is visible, as a share of it: on both sides, and ahead of a window that moves. */
const MARGIN = 0.25;
const AHEAD = 1;
/** Most that is read of what is near, bytes an answer, and the bins that the server has in memory. */
const NEAR_BYTES = 6e6;
const PYRAMID = 16;
/** What is near is read so much finer than what is visible. */
const FINER = 4;

/** Returns the samples [from, to) of a stretch of time. */
export function samplesOf({ from, to }: Range, { ticks, period }: Length) {
  const first = Math.min(ticks - 1, Math.max(0, Math.floor(from / period)));
  return { from: first, to: Math.min(ticks, Math.max(first + 1, Math.ceil(to / period) + 1)) };
}

/** The largest bin with which a stretch of time is drawn as finely as there are pixels, s. */
export function stepFor(
  { from, to }: Range,
  { period }: Pick<Length, 'period'>,
  finer = 1,
): number {
  return Math.max(period, (to - from) / (finer * LEAST_BINS)) * (1 + 1e-9);
}

/** What the curves of a whole run in `BINS` bins are at least. */
export function wholeOf({ duration }: Length): Grid {
  return { start: 0, step: (2 * duration) / BINS, last: BINS / 2 };
}

/**
 * Returns what is worth reading while nothing else is: the whole run in the least bins that the
 * server has in memory, what is visible finer, and as much on both sides of it.
 */
export function nearby(visible: Range, run: Length, columns: number): (Reading & Step)[] {
  const most = Math.floor(NEAR_BYTES / (8 * Math.max(1, columns)));
  const length = visible.to - visible.from;
  const sides = { from: visible.from - length, to: visible.to + length };
  const ways = [
    { range: { from: 0, to: run.duration }, points: Math.ceil(run.ticks / PYRAMID) },
    { range: within(visible, run), points: FINER * BINS },
    { range: within(sides, run), points: 3 * BINS },
  ];
  return ways.flatMap(({ range, points }) => {
    if (!range) return [];
    const bins = Math.min(points, most);
    // The server may round bins up, by less than twice.
    const step = Math.max(run.period, (2 * (range.to - range.from)) / bins) * (1 + 1e-9);
    return [{ range, points: bins, step }];
  });
}

interface Step {
  /** The largest bin of curves that make reading it needless, s. */
  step: number;
}

export interface Reading {
  range: Range;
  points: number;
}

/**
 * Returns what to read so that `visible` is drawn as finely as there are pixels, with a margin;
 * null where what is there suffices. A window that moves is read ahead of.
 */
export function toRead(
  visible: Range,
  there: readonly (Grid | null)[],
  run: Length,
  { moving = false, finer = 1 } = {},
): Reading | null {
  const length = visible.to - visible.from;
  const soon = { from: visible.from, to: visible.to + (moving ? MARGIN * length : 0) };
  const needed = within(soon, run);
  if (!needed) return null;
  const step = stepFor(visible, run, finer);
  if (there.some((grid) => grid && grid.step <= step && covers(grid, needed))) return null;
  const ahead = moving ? AHEAD : MARGIN;
  const range = within(
    { from: visible.from - MARGIN * length, to: visible.to + ahead * length },
    run,
  );
  if (!range) return null;
  const points = Math.ceil((finer * BINS * (range.to - range.from)) / length);
  return { range, points: Math.min(points, BINS_MAX) };
}
