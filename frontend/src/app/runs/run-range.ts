/** Which samples of a run are read for a stretch of time. */

import type { Range, SampleSource, StillSource } from '../../plot/source';
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

/** The part of a stretch of time that lies within a run; null where none does. */
export function within({ from, to }: Range, { duration }: Pick<Length, 'duration'>): Range | null {
  const part = { from: Math.max(0, from), to: Math.min(duration, to) };
  return part.to > part.from ? part : null;
}

type Grid = Pick<SampleSource, 'start' | 'step' | 'last'>;

/** Whether curves reach over a stretch of time. */
export function covers({ start, step, last }: Grid, { from, to }: Range): boolean {
  return start <= from + step && start + last * step >= to - step;
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

/** Most that the curves of one view take, bytes; those used longest ago go first. */
export const SEEN_MAX = 24e6;

/** Curves so much finer than needed are left for coarser ones. */
const FINEST = 16;

interface Seen {
  columns: ReadonlySet<string>;
  source: StillSource;
  bytes: number;
}

export class SeenCurves {
  bytes = 0;
  /** Used longest ago first. */
  private seen: Seen[] = [];

  private drawn: StillSource | null = null;

  constructor(private readonly most = SEEN_MAX) {}

  put(columns: readonly string[], source: StillSource): void {
    // Least and most of each bin, float32.
    const bytes = 8 * columns.length * source.last;
    // What is drawn stays the last one.
    const place =
      this.seen.at(-1)?.source === this.drawn
        ? Math.max(0, this.seen.length - 1)
        : this.seen.length;
    this.seen.splice(place, 0, { columns: new Set(columns), source, bytes });
    this.bytes += bytes;
    while (this.bytes > this.most && this.seen.length > 1) {
      this.bytes -= this.seen.shift()?.bytes ?? 0;
    }
  }

  /**
   * The curves to draw a stretch of time from: the coarsest that are fine enough, for they are drawn
   * fastest, else the finest that there are of all of it. Those drawn last stay while they will do.
   */
  best(columns: readonly string[], range: Range, step: number): StillSource | null {
    const last = this.seen.at(-1);
    const stays = last?.source === this.drawn && last && fits(last, columns, range);
    if (stays && last.source.step <= step && last.source.step * FINEST >= step) return last.source;
    const curves = this.find(columns, range, step);
    if (!curves) return null;
    this.seen = [...this.seen.filter((each) => each !== curves), curves];
    this.drawn = curves.source;
    return curves.source;
  }

  /** Whether there are curves of a stretch of time with at most such bins. */
  has(columns: readonly string[], range: Range, step: number): boolean {
    return (this.find(columns, range, step)?.source.step ?? Number.POSITIVE_INFINITY) <= step;
  }

  private find(columns: readonly string[], range: Range, step: number): Seen | null {
    let best: Seen | null = null;
    for (const each of this.seen) {
      if (!fits(each, columns, range)) continue;
      const [a, b] = [each.source.step, best?.source.step ?? Number.POSITIVE_INFINITY];
      if (b > step ? a < b : a <= step && a > b) best = each;
    }
    return best;
  }
}

function fits({ columns, source }: Seen, names: readonly string[], range: Range): boolean {
  return covers(source, range) && names.every((name) => columns.has(name));
}
