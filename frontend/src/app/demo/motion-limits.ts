/** What a motion requires of its motor, tick by tick, as trajectories/motion_limits.py has it; without thrust. */

import type { Axis } from '../../kernel/lanes';
import { AXES } from '../../kernel/module';
import type { ProblemField, Scenario, Value } from '../api/types';
import { type Bounds, outOfRange, Refused } from '../whatif/refused-changes';
import type { MotionCode } from './motion-code';
import type { Reference } from './reference';

const POSITION_ROUNDING = 1e-12;
const ROUNDING = 1e-9;

/** Bounds of fields, by the kind of a motion and their names. */
export type MotionRanges = Readonly<Record<string, Readonly<Record<string, Bounds>>>>;

export interface Demand {
  quantity: 'position' | 'step' | 'velocity' | 'acceleration';
  axis: Axis;
  unit: string;
  /** One of each tick; of positions also the end, whose other quantities are 0. */
  values: Float64Array;
  /** Largest magnitude, and what rounding may add. */
  limit: number;
  slack: number;
}

/** Quantities by axis, in the order of their bits in the column `violated`. */
export function demands(
  code: MotionCode,
  { columns, end, ticks }: Reference,
  plant: Scenario['plant'],
): Demand[] {
  return AXES.flatMap((axis, i) => {
    const [p, v, a] = columns.slice(3 * i, 3 * i + 3) as [Float64Array, Float64Array, Float64Array];
    const column = () => new Float64Array(ticks + 1);
    const [position, step, velocity, acceleration] = [column(), column(), column(), column()];
    position.set(p);
    position[ticks] = end[i] as number;
    velocity.set(v);
    for (let k = 0; k < ticks; k++) {
      const [now, before] = [v[k] as number, k > 0 ? (v[k - 1] as number) : 0];
      if (k > 0) step[k] = code.jump((p[k] as number) - (p[k - 1] as number), now, before);
      acceleration[k] = code.mean_acceleration(a[k] as number, now, before);
    }
    const { stroke, velocity_max, acceleration_max } = plant[axis];
    const of = (
      quantity: Demand['quantity'],
      unit: string,
      values: Float64Array,
      limit: number,
    ): Demand => {
      const slack = unit === 'm' ? POSITION_ROUNDING : ROUNDING * limit;
      return { quantity, axis, unit, values, limit, slack };
    };
    return [
      of('position', 'm', position, stroke),
      of('step', 'm', step, code.STEP_MAX),
      of('velocity', 'm/s', velocity, velocity_max),
      of('acceleration', 'm/s^2', acceleration, acceleration_max),
    ];
  });
}

/** The first tick at which a quantity is largest. */
export function peakOf({ values }: Demand): number {
  let peak = 0;
  for (let k = 1; k < values.length; k++) {
    if (Math.abs(values[k] as number) > Math.abs(values[peak] as number)) peak = k;
  }
  return peak;
}

/** What of a motion exceeds stroke, steps, velocity or acceleration of its motor. */
export function infeasible(
  code: MotionCode,
  reference: Reference,
  plant: Scenario['plant'],
): ProblemField[] {
  return demands(code, reference, plant).flatMap((demand) => {
    const { quantity, axis, unit, limit, slack } = demand;
    const value = Math.abs(demand.values[peakOf(demand)] as number);
    if (value <= limit + slack) return [];
    const name = quantity === 'step' ? 'a step' : quantity;
    const message = `${name} of ${axis} exceeds the motor's`;
    return [{ loc: 'trajectory', message, value, bounds: { maximum: limit }, unit }];
  });
}

/** @throws Refused where a number of a motion is out of its range */
export function checkRanges(trajectory: Scenario['trajectory'], ranges: MotionRanges): void {
  const own = ranges[trajectory.kind];
  const problems = Object.entries(trajectory).flatMap(([name, value]) =>
    outOfRange(`trajectory.${name}`, value as Value, own?.[name]),
  );
  if (problems.length > 0) throw new Refused(problems);
}
