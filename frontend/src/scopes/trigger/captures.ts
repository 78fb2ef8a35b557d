/** Stretches of curves around the moments at which a scope was triggered. */

import type { GhostRun } from '../../plot/run-overlay';
import { StillSource, type Envelope, type Range, type SampleSource } from '../../plot/source';

export interface Origin {
  session: string;
  timeline: number;
}

export interface Capture {
  /** Tells it from the others; of one that was kept before, its run. */
  key: string;
  /** When it was triggered, s. */
  time: number;
  range: Range;
  /** Every sample of the stretch. */
  source: StillSource;
  /** Without a hit: what auto shows meanwhile. */
  free: boolean;
  /** Whether it is drawn from its own samples; else it is a stretch of what its view shows anyway. */
  apart: boolean;
  /** The session and the timeline of it that it is of; null of what-ifs and runs. */
  origin: Origin | null;
  /** Ticks [first, stop) of these, and the one at which it was triggered. */
  ticks: readonly [number, number];
  tick: number;
  /** The run that it is kept as; empty while it is not, `…` while it is being kept. */
  run: string;
  /** Why it could not be kept. */
  problem: string;
}

/** Copies every sample of a stretch, for as long as it is wanted. */
export function copied(
  source: SampleSource,
  columns: readonly string[],
  first: number,
  count: number,
) {
  const copies = new Map<string, Envelope>();
  for (const column of columns) {
    if (!source.has(column)) continue;
    const values = new Float32Array(count);
    source.reduce(
      column,
      { first, size: 1, count, paired: false },
      values,
      new Float32Array(count),
    );
    copies.set(column, { minimum: values, maximum: values });
  }
  return new StillSource(source.start + first * source.step, source.step, count, copies);
}

/** Every sample of a column. */
export function samplesOf(source: StillSource, column: string): Float32Array {
  return Float32Array.from({ length: source.last }, (_, i) =>
    source.at(column, source.start + (i + 0.5) * source.step),
  );
}

/**
 * The mean of captures, sample by sample from their triggers, on the time axis of one of them: of those
 * that have a sample there.
 */
export function averaged(captures: readonly Capture[], columns: readonly string[], on: Capture) {
  const { source: grid, time } = on;
  const curves = new Map<string, Envelope>();
  for (const column of columns) {
    const values = new Float32Array(grid.last);
    for (let i = 0; i < grid.last; i++) {
      const ahead = grid.start + (i + 0.5) * grid.step - time;
      let [sum, count] = [0, 0];
      for (const each of captures) {
        const value = each.source.at(column, each.time + ahead);
        if (Number.isNaN(value)) continue;
        sum += value;
        count += 1;
      }
      values[i] = sum / count;
    }
    curves.set(column, { minimum: values, maximum: values });
  }
  return new StillSource(grid.start, grid.step, grid.last, curves);
}

const DOT = 1;
const LONG = 0;

/** What lies behind a capture: others aligned with it at their triggers, and the mean of some. */
export function laidBehind(
  on: Capture,
  columns: readonly string[],
  { overlaid, mean }: { overlaid: readonly Capture[]; mean: readonly Capture[] },
): GhostRun[] {
  const ghosts = overlaid
    .filter((each) => each.key !== on.key)
    .map(({ source, time }) => ghostOf(source.shifted(on.time - time), DOT));
  if (mean.length > 1) ghosts.push(ghostOf(averaged(mean, columns, on), LONG));
  return ghosts;
}

function ghostOf(source: StillSource, slot: number): GhostRun {
  return { shown: true, slot, has: (column) => source.has(column), over: () => source };
}
