/** Effects of every number on a metric, the largest first. */

import type { SensitivityResult } from '../../app/api/types';
import { nameOf } from '../../app/fields/fields.svelte';

export type FieldEffect = SensitivityResult['variants'][string][string][string];

export interface Effect {
  path: string;
  value: number;
  /** Change of the metric with the low and the high value, SI; null where it has none. */
  down: number | null;
  up: number | null;
  /** The larger of both. */
  size: number;
}

/** Effects that there are, by size; of equal ones in the order of the scenario. */
export function effectsOf({ fields }: SensitivityResult, effect: FieldEffect): Effect[] {
  const { base, low, high } = effect;
  const by = (value: number | null | undefined) =>
    value === null || value === undefined || base === null ? null : value - base;
  return fields
    .map(({ path, value }, k) => {
      const [down, up] = [by(low[k]), by(high[k])];
      return { path, value, down, up, size: Math.max(Math.abs(down ?? 0), Math.abs(up ?? 0)) };
    })
    .filter(({ size }) => size > 0)
    .sort((a, b) => b.size - a.size);
}

/** Name of a number; of one in a list, such as the gains of three phases, with its place. */
export function numberName(path: string): string {
  const [, list, place] = /^(.*)\.(\d+)$/.exec(path) ?? [];
  return list === undefined ? nameOf(path) : `${nameOf(list)} ${Number(place) + 1}`;
}
