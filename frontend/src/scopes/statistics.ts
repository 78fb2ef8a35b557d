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

/** Samples of a stretch of time, as least and largest of each; valid until the next call. */
function samples(source: SampleSource, column: string, { from, to }: Range) {
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

/** Times and values of a stretch of a curve: its peak, and what it is as a response to a step. */
export interface Response {
  least: number;
  most: number;
  /** The sample farthest from zero, and when it comes. */
  peak: number;
  peakAt: number;
  /** From a tenth to nine tenths of the way from the first sample to the last, s. */
  rise: number;
  /** From the begin until it stays within 2 % of that way from the last sample, s. */
  settling: number;
  /** Beyond the last sample, as a share of that way. */
  overshoot: number;
}

/** A way shorter than this share of peak to peak is no step. */
const STEP = 0.1;
const BAND = 0.02;

/** Returns the peak of a curve over a stretch of time and, where it is a step, how it is taken. */
export function response(source: SampleSource, column: string, range: Range): Response {
  const { low, high, count, time } = samples(source, column, range);
  const none = Number.NaN;
  const figures: Response = { least: Infinity, most: -Infinity, peak: none, peakAt: none, rise: none, settling: none, overshoot: none }; // prettier-ignore
  const value = (i: number) => ((low[i] as number) + (high[i] as number)) / 2;
  for (let i = 0; i < count; i++) {
    const [a, b] = [low[i] as number, high[i] as number];
    if (!(a <= b)) continue; // a gap
    figures.least = Math.min(figures.least, a);
    figures.most = Math.max(figures.most, b);
    const farther = -a > b ? a : b;
    if (Number.isNaN(figures.peak) || Math.abs(farther) > Math.abs(figures.peak)) {
      [figures.peak, figures.peakAt] = [farther, time(i)];
    }
  }
  const [first, last] = [value(0), value(count - 1)];
  const way = last - first;
  if (!(Math.abs(way) > STEP * (figures.most - figures.least))) return figures;
  const share = (i: number) => (value(i) - first) / way;
  let [begin, end, outside] = [-1, -1, -1];
  for (let i = 0; i < count; i++) {
    if (begin < 0 && share(i) >= 0.1) begin = i;
    if (end < 0 && share(i) >= 0.9) end = i;
    if (Math.abs(share(i) - 1) > BAND) outside = i;
  }
  figures.rise = begin >= 0 && end >= begin ? time(end) - time(begin) : none;
  figures.settling = time(outside + 1) - time(0);
  const beyond = way > 0 ? figures.most - last : last - figures.least;
  figures.overshoot = Math.max(0, beyond / Math.abs(way));
  return figures;
}
