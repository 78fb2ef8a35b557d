/** The answer of a check in words. */

import type { Replay, RunDetail } from '../../app/api/types';
import { durationText } from '../../parts/runs/run-text';
import { digits, minus, prettyUnit } from '../../ui/units';

type First = NonNullable<Replay['first']>;

/**
 * What was compared, and what was not: the beginning of a session that went on for long has gone,
 * and is simulated without being compared.
 */
export function identicalText(
  { channels, ticks, missing }: Replay,
  { first_tick: gone, period }: Pick<RunDetail, 'first_tick' | 'period'>,
): string {
  const begun = gone > 0 ? `; the first ${durationText(gone * period)} have gone` : '';
  const rest = missing - gone;
  const without = rest > 0 ? `; ${rest.toLocaleString('en')} without a record` : '';
  return `${channels} channels, ${ticks.toLocaleString('en')} ticks${begun}${without}`;
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
