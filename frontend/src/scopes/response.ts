/** A stretch of a curve as a response to a step. */

import type { Range } from '../plot/range';
import type { SampleSource } from '../plot/source';
import { samples } from './statistics';

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
