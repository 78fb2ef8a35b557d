/** The difference of two curves, in bins. */

import type { Curve } from '../kernel/tasks';

export type Samples = Float32Array<ArrayBuffer>;

/** Returns the least and the largest of a - b in each bin of so many samples; the last may hold fewer. */
export function differenceOf(a: Samples, b: Samples, size: number): Curve {
  const bins = Math.ceil(a.length / size);
  const [minimum, maximum] = [new Float32Array(bins), new Float32Array(bins)];
  for (let bin = 0; bin < bins; bin++) {
    let [low, high] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
    for (let k = bin * size; k < Math.min(a.length, (bin + 1) * size); k++) {
      const value = (a[k] as number) - (b[k] as number);
      low = Math.min(low, value); // of NaN it is NaN: the curve has a gap
      high = Math.max(high, value);
    }
    minimum[bin] = low;
    maximum[bin] = high;
  }
  return { minimum, maximum };
}
