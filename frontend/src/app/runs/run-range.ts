/** Which samples of a run are read for a stretch of time. */

import type { Range, SampleSource } from '../../plot/source';
import type { RunDetail } from '../api/types';

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

/** Returns the samples [from, to) of a stretch of time. */
export function samplesOf({ from, to }: Range, { ticks, period }: Length) {
  const first = Math.min(ticks - 1, Math.max(0, Math.floor(from / period)));
  return { from: first, to: Math.min(ticks, Math.max(first + 1, Math.ceil(to / period) + 1)) };
}

/** The part of a stretch of time that lies within a run; null where none does. */
export function within({ from, to }: Range, { duration }: Length): Range | null {
  const part = { from: Math.max(0, from), to: Math.min(duration, to) };
  return part.to > part.from ? part : null;
}

type Grid = Pick<SampleSource, 'start' | 'step' | 'last'>;

/** Whether curves reach over a stretch of time. */
export function covers({ start, step, last }: Grid, { from, to }: Range): boolean {
  return start <= from + step && start + last * step >= to - step;
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
  moving: boolean,
): Reading | null {
  const length = visible.to - visible.from;
  const soon = { from: visible.from, to: visible.to + (moving ? MARGIN * length : 0) };
  const wanted = within(soon, run);
  if (!wanted) return null;
  const step = Math.max(run.period, length / LEAST_BINS) * (1 + 1e-9);
  if (there.some((grid) => grid && grid.step <= step && covers(grid, wanted))) return null;
  const ahead = moving ? AHEAD : MARGIN;
  const range = within(
    { from: visible.from - MARGIN * length, to: visible.to + ahead * length },
    run,
  );
  if (!range) return null;
  const points = Math.ceil((BINS * (range.to - range.from)) / length);
  return { range, points: Math.min(points, BINS_MAX) };
}
