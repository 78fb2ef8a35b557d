/** How a path over time becomes points: both extremes of each bin, so that no corner or peak is lost. */

import { pointsOf, writeCurve, type Bins } from './bins';
import type { Range } from './range';
import type { SampleSource } from './source';

const LEAST = 1000;
const MOST = 8000;
/** Longest bin while there are not too many of them, s. */
const FINE = 6e-3;

/** Cuts a stretch of time into the bins of a path: finer than its corners, whatever its length. */
export function pathBins(source: SampleSource, { from, to }: Range): Bins {
  const bins = Math.min(MOST, Math.max(LEAST, Math.ceil((to - from) / FINE)));
  return source.cut(from, to, bins);
}

/** Reads a column, two values for each bin that has several samples. */
export function pathValues(source: SampleSource, column: string, bins: Bins): Float32Array {
  const [low, high] = [new Float32Array(bins.count), new Float32Array(bins.count)];
  source.reduce(column, bins, low, high);
  const values = new Float32Array(pointsOf(bins));
  writeCurve(bins, low, high, values);
  return values;
}
