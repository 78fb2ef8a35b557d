/** What a retiming costs: the motion as it is beside the one that is proposed. */

import type { DrawnPath } from './drawn-path';
import type { Checked } from './feasibility';
import { among, prettyUnit, scaleFor } from '../../ui/units';

/** Numbers that time a path and nothing else. */
export type Timing = Pick<DrawnPath, 'law' | 'v_max' | 'a_max' | 'j_max' | 'lap_time'>;

export function timingOf({ law, v_max, a_max, j_max, lap_time }: DrawnPath): Timing {
  return { law, v_max, a_max, j_max, lap_time };
}

export interface Cost {
  name: string;
  title: string;
  unit: string;
  now: string;
  then: string;
  /** Then over now less 1; null where now is 0 or unknown. */
  change: number | null;
}

interface Measure {
  name: string;
  title: string;
  unit: string;
  of: (checked: Checked) => number;
}

const MEASURES: readonly Measure[] = [
  { name: 'lap time', title: 'Once along the path', unit: 's', of: (checked) => checked.examined },
  {
    name: 'speed',
    title: 'Peak along the path',
    unit: 'm/s',
    of: (checked) => most(checked, 'speed'),
  },
  {
    name: 'peak accel.',
    title: 'Peak acceleration of either axis',
    unit: 'm/s^2',
    of: (checked) => either(checked, 'acceleration'),
  },
  {
    name: 'peak jerk',
    title: 'Peak of either axis',
    unit: 'm/s^3',
    of: (checked) => either(checked, 'jerk'),
  },
  {
    name: 'thrust',
    title: 'Largest share of what the motor has at that place',
    unit: '%',
    of: (checked) =>
      100 *
      Math.max(
        ...checked.peaks.map(({ quantity, share }) => {
          return quantity === 'thrust' ? (share ?? 0) : 0;
        }),
      ),
  },
];

/** Returns lap time and peaks of both motions; dashes for one that is not known. */
export function costs(now: Checked | null, then: Checked | null): Cost[] {
  const known = (quantity: string) =>
    [now, then].some((each) => each?.peaks.some((peak) => peak.quantity === quantity));
  // A demo finds no thrust.
  const measures = MEASURES.filter(({ name }) => name !== 'thrust' || known(name));
  return measures.map(({ name, title, unit, of }) => {
    const [before, after] = [now && of(now), then && of(then)];
    const change = before && after !== null && before > 0 ? after / before - 1 : null;
    const largest = Math.max(before ?? 0, after ?? 0);
    // Accelerations in m/s² and their shares as they are, as on the whole screen.
    const scale = unit === 'm/s' ? scaleFor(largest, unit) : { factor: 1, unit: prettyUnit(unit) };
    const text = (value: number | null) => (value === null ? '–' : among(value, scale));
    return { name, title, unit: scale.unit, now: text(before), then: text(after), change };
  });
}

function either(checked: Checked, quantity: string): number {
  return Math.max(most(checked, `x.${quantity}`), most(checked, `y.${quantity}`));
}

/** Largest magnitude of a profile. */
function most({ columns }: Checked, name: string): number {
  const { minimum, maximum } = columns.get(name) ?? { minimum: [], maximum: [] };
  let largest = 0;
  for (const value of minimum) largest = Math.max(largest, -value);
  for (const value of maximum) largest = Math.max(largest, value);
  return largest;
}
