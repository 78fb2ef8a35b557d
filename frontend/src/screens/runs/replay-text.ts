/** The answer of a check in words. */

import type { Replay } from '../../app/api/types';
import { digits, minus, prettyUnit } from '../../ui/units';

type First = NonNullable<Replay['first']>;

export function identicalText({ channels, ticks, missing }: Replay): string {
  const without = missing > 0 ? `; ${missing.toLocaleString('en')} without a record` : '';
  return `${channels} channels, ${ticks.toLocaleString('en')} ticks${without}`;
}

/** Both values with all digits that tell them apart. */
export function differenceText({ recorded, simulated, difference, unit }: First) {
  const of = prettyUnit(unit);
  return {
    recorded: valueText(recorded, of),
    simulated: valueText(simulated, of),
    by: difference === null ? '' : `: ${digits(difference)} ${of}`.trimEnd(),
  };
}

function valueText(value: number | string | null, unit: string): string {
  if (value === null) return 'missing';
  // Nine digits tell any two float32 apart.
  const text = typeof value === 'number' ? String(Number(value.toPrecision(9))) : value;
  return minus(`${text} ${unit}`.trimEnd());
}
