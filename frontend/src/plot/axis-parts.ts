/** Value axes of curves that are far smaller than the largest beside them: a round part of the first axis. */

import { roundStep } from './range';

/** A curve whose values are so many times smaller than those beside it gets an axis of its own. */
const SMALLER = 5;
/** It keeps that until they are only so many times smaller. */
const AGAIN = 3;
type Extent = readonly [number, number];

/** Returns the least and the largest of some extents, and zero. */
export function endsOf(extents: readonly Extent[]): Extent {
  const some = extents.filter(([low, high]) => low <= high);
  return [Math.min(0, ...some.map(([low]) => low)), Math.max(0, ...some.map(([, high]) => high))];
}

/**
 * Returns how large the axis of each curve is of the first one, from the ends of the curves with what
 * lies behind them, and from the parts that they have now; 0 for the first axis itself.
 */
export function axisParts(ends: readonly Extent[], present: readonly number[]): number[] {
  const sizes = ends.map(([low, high]) => Math.max(-low, high));
  const largest = Math.max(...sizes);
  return sizes.map((size, i) => {
    const before = present[i] ?? 0;
    if (!(size > 0 && size * (before > 0 ? AGAIN : SMALLER) < largest)) return 0;
    const part = roundStep(size / largest / 1.001);
    // A factor that still fits, without much room lost, stays.
    return before >= size / largest && before <= 2.6 * part ? before : part;
  });
}
