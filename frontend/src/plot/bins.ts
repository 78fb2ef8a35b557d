/** How a stretch of time is cut into bins that are about as many as there are pixels. */

export interface Bins {
  /** Index of the first sample of the first bin. */
  first: number;
  /** Samples in a bin, a power of two. */
  size: number;
  count: number;
  /** Whether a bin is drawn by its two extremes; else it is one sample. */
  paired: boolean;
}

/**
 * Cuts samples `from` to `to` into at most about `pixels` bins.
 *
 * Bins start at multiples of their size: as the window slides, each keeps its samples, so that a
 * curve moves along instead of shimmering.
 */
export function cut(from: number, to: number, pixels: number): Bins {
  const span = Math.max(1, to - from);
  let size = 1;
  while (span / size > pixels) size *= 2;
  const first = Math.floor(from / size) * size;
  const count = Math.max(1, Math.ceil((to - first) / size));
  return { first, size, count, paired: size > 1 };
}

/** Returns how many points a curve of these bins has: two for a paired bin, else one. */
export function pointsOf({ paired, count }: Bins): number {
  return paired ? 2 * count : count;
}

/**
 * Writes both extremes of each bin, in the order in which the curve is likely to pass them: a rising
 * one goes through its minimum first. So extremes are kept, and slopes stay smooth when zoomed in.
 * Points are evenly spaced in time; NaN is where there is nothing. Those of bins before `first` stay.
 */
export function writeCurve(
  bins: Bins,
  minimum: Float32Array,
  maximum: Float32Array,
  values: Float32Array,
  first = 0,
): void {
  const { count, paired } = bins;
  let before =
    first > 0 ? (minimum[first - 1] as number) + (maximum[first - 1] as number) : Number.NaN;
  for (let i = first; i < count; i++) {
    const low = minimum[i] as number;
    if (!paired) {
      values[i] = low;
      continue;
    }
    const high = maximum[i] as number;
    const middle = low + high;
    const falls = middle < before;
    values[2 * i] = falls ? high : low;
    values[2 * i + 1] = falls ? low : high;
    before = middle;
  }
}
