/** What stands at the axes of a scope: round values, and their texts with the unit at the last. */

import { minus, scaleFor } from '../ui/units';
import { multiples, roundStep, type Range } from './range';

/** Least distances between two values and between two times, CSS pixels. */
const ROW = 24;
const COLUMN = 70;

/** Returns the values that a value axis of some height has lines at. */
export function valueSplits(range: Range, height: number): number[] {
  const { from, to } = range;
  const lines = height / ROW;
  // Little room: the ends, which are round, and zero.
  const apart = 0.35 * (to - from);
  const splits = multiples(range, roundStep((to - from) / Math.min(6, lines)));
  if (lines >= 2.5 && splits.length > 2) return splits;
  return -from > apart && to > apart ? [from, 0, to] : [from, to];
}

/** Returns the text of each value, in the unit that suits the largest. */
export function valueTexts(splits: readonly number[], of: string): string[] {
  const { factor, unit } = scaleFor(Math.max(...splits.map(Math.abs)), of);
  const step = Math.min(...splits.slice(1).map((split, i) => split - (splits[i] ?? 0))) * factor;
  // So many places as tell neighbours apart, and a half where the step has one.
  const places = Number.isFinite(step) ? Math.max(0, Math.ceil(-Math.log10(step / 1.01))) : 0;
  return splits.map((split, i) => {
    const text = minus(String(Number((split * factor).toFixed(places + 1))));
    return i === splits.length - 1 ? `${text} ${unit}` : text;
  });
}

/** Returns the times that a time axis of some width has lines at. */
export function timeSplits(range: Range, width: number): number[] {
  return multiples(range, roundStep(((range.to - range.from) * COLUMN) / width));
}
