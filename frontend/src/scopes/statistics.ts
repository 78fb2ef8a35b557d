/** Statistics of a stretch of a curve, from all its samples. */

import type { Range } from '../plot/range';
import type { SampleSource } from '../plot/source';

export const STATISTICS = [
  { id: 'value', name: 'value', meaning: 'At the pointer or a cursor, else the newest' },
  { id: 'mean', name: 'mean', meaning: 'Mean' },
  { id: 'rms', name: 'RMS', meaning: 'Root of the mean square' },
  { id: 'span', name: 'p-p', meaning: 'Peak to peak: most less least' },
  { id: 'deviation', name: 'std', meaning: 'Standard deviation: RMS about the mean' },
] as const;

export type Statistic = (typeof STATISTICS)[number]['id'];
export type Statistics = Record<Exclude<Statistic, 'value'>, number>;

/** Of a period: a time that rounding has put before its sample is that sample's. */
const NEARLY = 1e-6;

/** From the sample that is read at one cursor to the one that is read at another, both included. */
export function between(cursors: readonly number[], period: number): Range {
  const ticks = cursors.map((time) => Math.floor(time / period + NEARLY));
  return { from: Math.min(...ticks) * period, to: (Math.max(...ticks) + 1) * period };
}

/** Samples of a stretch of time, as least and largest of each; valid until the next call. */
export function samples(source: SampleSource, column: string, { from, to }: Range) {
  const index = (time: number) => Math.round((time - source.start) / source.step);
  const first = Math.max(source.first, index(from));
  const count = Math.max(0, Math.min(source.last, index(to)) - first);
  if (low.length < count) {
    low = new Float32Array(count);
    high = new Float32Array(count);
  }
  source.reduce(column, { first, size: 1, count, paired: true }, low, high);
  return { low, high, count, time: (i: number) => source.start + (first + i) * source.step };
}

let low = new Float32Array(0);
let high = new Float32Array(0);

/**
 * Returns the statistics of a column over a stretch of time; NaN where there are no samples.
 *
 * A what-if of more than 10 s keeps least and most of bins of some periods. Between the two a curve is
 * taken as even: its mean is theirs, its mean square (a^2 + a b + b^2)/3.
 */
export function statistics(source: SampleSource, column: string, { from, to }: Range): Statistics {
  const { low, high, count } = samples(source, column, { from, to });
  let seen = 0;
  let sum = 0;
  let least = Number.POSITIVE_INFINITY;
  let most = Number.NEGATIVE_INFINITY;
  for (let i = 0; i < count; i++) {
    const [a, b] = [low[i] as number, high[i] as number];
    if (!(a <= b)) continue; // a gap
    seen += 1;
    sum += (a + b) / 2;
    if (a < least) least = a;
    if (b > most) most = b;
  }
  const mean = sum / seen;
  // About the mean, so that a small ripple on a large offset does not drown in rounding.
  let squares = 0;
  for (let i = 0; i < count; i++) {
    const [a, b] = [(low[i] as number) - mean, (high[i] as number) - mean];
    if (a <= b) squares += (a * a + a * b + b * b) / 3;
  }
  const deviation = Math.sqrt(squares / seen);
  return { mean, rms: Math.hypot(mean, deviation), span: most - least, deviation };
}
