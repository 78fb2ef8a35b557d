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

/** The points of one curve as uPlot takes them: null where there is nothing. */
export type Points = (number | null)[];

/** Writes the times of the points that `writeCurve` makes: two for a paired bin, else one. */
export function writeTimes(bins: Bins, start: number, step: number, times: number[]): void {
  const { first, size, count } = bins;
  if (!bins.paired) {
    times.length = count;
    for (let i = 0; i < count; i++) times[i] = start + (first + i * size) * step;
    return;
  }
  times.length = 2 * count;
  for (let i = 0; i < count; i++) {
    const time = start + (first + i * size) * step;
    times[2 * i] = time;
    times[2 * i + 1] = time + 0.5 * size * step;
  }
}

/**
 * Writes both extremes of each bin, in the order in which the curve is likely to pass them: a rising
 * one goes through its minimum first. So extremes are kept, and slopes stay smooth when zoomed in.
 */
export function writeCurve(
  bins: Bins,
  minimum: Float32Array,
  maximum: Float32Array,
  values: Points,
): void {
  const { count } = bins;
  if (!bins.paired) {
    values.length = count;
    for (let i = 0; i < count; i++) {
      const value = minimum[i] as number;
      values[i] = value === value ? value : null; // NaN is not itself
    }
    return;
  }
  values.length = 2 * count;
  let before = Number.NaN;
  for (let i = 0; i < count; i++) {
    const low = minimum[i] as number;
    const high = maximum[i] as number;
    if (low !== low) {
      values[2 * i] = null;
      values[2 * i + 1] = null;
      before = Number.NaN;
      continue;
    }
    const middle = low + high;
    const falls = middle < before;
    values[2 * i] = falls ? high : low;
    values[2 * i + 1] = falls ? low : high;
    before = middle;
  }
}
