/** Ranges of axes: round numbers, and calm while data move. */

export interface Range {
  from: number;
  to: number;
}

/** Returns the time at a share of a range. */
export function timeAt({ from, to }: Range, share: number): number {
  return from + share * (to - from);
}

/** Returns the step of 1, 2 or 5 times a power of ten that is at least `least`. */
export function roundStep(least: number): number {
  const power = 10 ** Math.floor(Math.log10(least));
  const mantissa = least / power;
  // The tolerance takes 2.0000000001 for 2.
  const step = [1, 2, 5, 10].find((candidate) => mantissa <= candidate * (1 + 1e-9)) ?? 10;
  return Number((step * power).toPrecision(12));
}

/** Returns the multiples of `step` within a range. */
export function multiples({ from, to }: Range, step: number): number[] {
  const ticks: number[] = [];
  for (let i = Math.ceil(from / step - 1e-9); i * step <= to + step * 1e-9; i++) {
    ticks.push(i === 0 ? 0 : Number((i * step).toPrecision(12)));
  }
  return ticks;
}

/** Returns a range with round ends around the data, with some room; of nothing but zeros, `still`. */
export function fit(low: number, high: number, still = 1): Range {
  if (!(low <= high)) return { from: -1, to: 1 };
  let span = high - low;
  const size = Math.max(Math.abs(low), Math.abs(high));
  // A constant, or one that differs by rounding only, gets a range of its own size.
  if (span <= size * 1e-6) span = size === 0 ? still : size * 0.5;
  const step = roundStep(span / 10);
  const from = Math.floor((low - 0.04 * span) / step) * step;
  const to = Math.ceil((high + 0.04 * span) / step) * step;
  // What has one sign, such as a current, begins at zero, not a little beyond.
  return {
    from: low >= 0 && high > 0 ? Math.max(0, from) : from,
    to: high <= 0 && low < 0 ? Math.min(0, to) : to,
  };
}

/**
 * Returns the range to show: what fits, unless the present one holds the data and is not much too
 * large, so that an axis does not jump about while a curve slides through it.
 */
export function calmRange(present: Range | null, low: number, high: number, still?: number): Range {
  const fitted = fit(low, high, still);
  if (!present) return fitted;
  const holds = present.from <= low && high <= present.to;
  const roomy = present.to - present.from > 1.6 * (fitted.to - fitted.from);
  return holds && !roomy ? present : fitted;
}
