/** Stretches of curves around the moments at which a scope was triggered. */

import type { GhostRun } from '../../plot/run-overlay';
import { StillSource, type Envelope, type Range, type SampleSource } from '../../plot/source';

export interface Origin {
  session: string;
  timeline: number;
}

export interface Capture {
  /** When it was triggered, s. */
  time: number;
  range: Range;
  /** Every sample of the stretch. */
  source: StillSource;
  /** Without a hit: what auto shows meanwhile. */
  free: boolean;
  /** The session and the timeline of it that it is of; null of what-ifs and runs. */
  origin: Origin | null;
  /** Ticks [first, stop) of these. */
  ticks: readonly [number, number];
  /** The run that it is kept as; empty while it is not, `…` while it is being kept. */
  run: string;
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

/** The mean of captures, sample by sample from their triggers, on the time axis of one of them. */
export function averaged(captures: readonly Capture[], columns: readonly string[], on: Capture) {
  const { source: grid, time } = on;
  const curves = new Map<string, Envelope>();
  for (const column of columns) {
    const values = new Float32Array(grid.last);
    for (let i = 0; i < grid.last; i++) {
      const ahead = grid.start + (i + 0.5) * grid.step - time;
      let sum = 0;
      for (const each of captures) sum += each.source.at(column, each.time + ahead);
      values[i] = sum / captures.length;
    }
    curves.set(column, { minimum: values, maximum: values });
  }
  return new StillSource(grid.start, grid.step, grid.last, curves);
}

const DOT = 1;
const LONG = 0;

/** What lies behind a capture: the others aligned with it at their triggers, and their mean. */
export function laidBehind(
  captures: readonly Capture[],
  on: Capture,
  columns: readonly string[],
  { overlay, average }: { overlay: boolean; average: boolean },
): GhostRun[] {
  const hits = captures.filter(({ free }) => !free);
  const drawn: StillSource[] = [];
  if (overlay) {
    const others = hits.filter((each) => each !== on);
    drawn.push(...others.map(({ source, time }) => source.shifted(on.time - time)));
  }
  const ghosts = drawn.map((source) => ghostOf(source, DOT));
  if (average && hits.length > 1) ghosts.push(ghostOf(averaged(hits, columns, on), LONG));
  return ghosts;
}

function ghostOf(source: StillSource, slot: number): GhostRun {
  return { shown: true, slot, has: (column) => source.has(column), over: () => source };
}
