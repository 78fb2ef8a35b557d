/** References of a circle, as trajectories/pieces.py samples them. */

import type { Lanes } from '../../kernel/lanes';
import { AXES, LANES } from '../../kernel/module';
import type { ProblemField, Scenario } from '../api/types';
import { Beyond } from '../whatif/changed-lanes';

/** Of position, velocity and acceleration. */
export const REFERENCE_ROWS = ['p_ref', 'v_ref', 'a_ref'] as const;

export interface Circle {
  kind: 'circle';
  center: { x: number; y: number };
  radius: number;
  /** Laps a second. */
  frequency: number;
  direction: 'ccw' | 'cw';
  start_angle: number;
  laps: number;
  for_ever: boolean;
  /** s; half a lap where it is null. */
  lead_in: number | null;
}

/** A clock that starts from rest and runs at full rate after `lead` ticks, its rate and that one's. */
function smoothStart(u: number, lead: number): [clock: number, rate: number, second: number] {
  if (lead === 0) return [u, 1, 0];
  const r = Math.min(u / lead, 1);
  const clock = lead * r ** 4 * (2.5 - 3 * r + r ** 2) + Math.max(u - lead, 0);
  return [clock, r ** 3 * (10 - 15 * r + 6 * r ** 2), (30 * r ** 2 * (1 - r) ** 2) / lead];
}

/** Longest motion, summed over variants, s: a worker's memory. */
const MOST = 60;

/**
 * Returns the lanes of a scenario with another circle in place of its own.
 *
 * @throws Beyond where the motion is too long
 */
export function withCircle(lanes: Lanes, circle: Circle, startRow: number): Lanes {
  const { period: T } = lanes;
  const whole = (seconds: number) => (seconds > 0 ? Math.max(1, Math.round(seconds / T)) : 0);
  const lap = whole(1 / circle.frequency);
  const lead = whole(circle.lead_in ?? 0.5 / circle.frequency);
  const ticks = lead + circle.laps * lap;
  // Before anything is allocated: laps and their duration may be any.
  if (ticks * T * lanes.tabled.length > MOST) {
    throw new Beyond(`the motion takes more than ${MOST} s, summed over variants`);
  }
  const turn = ((circle.direction === 'ccw' ? 1 : -1) * 2 * Math.PI) / lap;
  const rows = AXES.flatMap((axis) => REFERENCE_ROWS.map((row) => [row, axis] as const));
  const inputs = new Float64Array(rows.length * ticks);
  AXES.forEach((axis, i) => {
    const phase = circle.start_angle + (axis === 'x' ? Math.PI / 2 : 0);
    const [p, v, a] = REFERENCE_ROWS.map((_, row) =>
      inputs.subarray((REFERENCE_ROWS.length * i + row) * ticks).subarray(0, ticks),
    ) as [Float64Array, Float64Array, Float64Array];
    for (let tick = 0; tick < ticks; tick++) {
      const [clock, rate, second] = smoothStart(tick, lead);
      const sine = circle.radius * Math.sin(turn * clock + phase);
      const cosine = circle.radius * Math.cos(turn * clock + phase);
      p[tick] = circle.center[axis] + sine;
      v[tick] = (cosine * turn * rate) / T;
      a[tick] = (cosine * turn * second - sine * (turn * rate) ** 2) / T ** 2;
    }
  });
  const state = lanes.state.slice();
  const variants = lanes.tabled.length;
  const states = state.length / (variants * LANES);
  for (let variant = 0; variant < variants; variant++) {
    AXES.forEach((_, lane) => {
      state[(variant * states + startRow) * LANES + lane] = inputs[
        REFERENCE_ROWS.length * lane * ticks
      ] as number;
    });
  }
  // The last two laps, but not the first of several.
  const measured = Math.max(1, Math.min(2, circle.laps - 1)) * lap;
  const window = { start: Math.max(0, ticks - measured), end: ticks };
  return {
    ...lanes,
    keys: { ...lanes.keys, inputs: JSON.stringify(circle) },
    ticks,
    stop: ticks,
    rows: rows.map(([row, axis]) => [row, axis]),
    inputs,
    state,
    windows: lanes.windows.map((each) => ({ ...each, ...window })),
  };
}

/** What of a motion exceeds the stroke, velocity or acceleration of its motor. */
export function infeasible({ inputs, stop }: Lanes, plant: Scenario['plant']): ProblemField[] {
  return AXES.flatMap((axis, i) => {
    const { stroke, velocity_max, acceleration_max } = plant[axis];
    const limits = [
      ['position', stroke, 'm'],
      ['velocity', velocity_max, 'm/s'],
      ['acceleration', acceleration_max, 'm/s^2'],
    ] as const;
    return limits.flatMap(([name, maximum, unit], row) => {
      const first = (REFERENCE_ROWS.length * i + row) * stop;
      const peak = inputs
        ?.subarray(first, first + stop)
        .reduce((most, value) => Math.max(most, Math.abs(value)), 0);
      if (peak === undefined || peak <= maximum) return [];
      const message = `${name} of ${axis} exceeds the motor's`;
      return [{ loc: 'trajectory', message, value: peak, bounds: { maximum }, unit }];
    });
  });
}
