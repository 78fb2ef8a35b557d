/** The same path, slower, until the motor can follow it, as trajectories/retiming.py finds it; without thrust. */

import type { ProblemField, Scenario } from '../api/types';
import { Beyond } from '../whatif/changed-lanes';
import { Refused } from '../whatif/refused-changes';
import type { MotionCode } from './motion-code';
import { infeasible } from './motion-limits';
import { motionOf, oneLap } from './path-check';

type Trajectory = Scenario['trajectory'];

/** Exponents by which the numbers of a motion profile scale with time; dwells stay. */
const POWERS = {
  duration: 1,
  lead_in: 1,
  edge_time: 1,
  lap_time: 1,
  frequency: -1,
  v_max: -1,
  velocity: -1,
  a_max: -2,
  coefficient: -2,
  j_max: -3,
} as const;
const RESTS: readonly string[] = ['point', 'dwell', 'step'];
const LARGEST = 1e4;
/** Longest motion that is slowed down, before or after, s: each trial samples all of it. */
const LONGEST = 40;
const PRECISION = 1e-3;

/** @throws Refused where the path leaves the stroke or jumps, Beyond where it gets too long */
export function slowDown(
  code: MotionCode,
  trajectory: Trajectory,
  plant: Scenario['plant'],
): { trajectory: Trajectory; stretch: number; duration: number } {
  const problems = (each: Trajectory): ProblemField[] =>
    infeasible(code, motionOf(code, oneLap(each)[0], LONGEST), plant);
  const whole = (each: Trajectory, stretch: number) => {
    const [one, laps] = oneLap(each);
    const { ticks, period } = motionOf(code, one);
    const duration = (ticks + (laps - 1) * period) * code.CONTROL_PERIOD;
    return { trajectory: each, stretch, duration };
  };
  const first = problems(trajectory);
  if (first.length === 0) return whole(trajectory, 1);
  const lasting = first.filter(({ message }) => /^(position|a step) /.test(message));
  if (lasting.length > 0) throw new Refused(lasting);
  const holds = (stretch: number) => problems(stretched(trajectory, stretch)).length === 0;
  let [low, high] = [1, 2];
  while (!holds(high)) {
    [low, high] = [high, 2 * high];
    if (high > LARGEST) throw new Beyond('it stays infeasible however slow it is');
  }
  while (high / low > 1 + PRECISION) {
    const middle = Math.sqrt(low * high);
    if (holds(middle)) high = middle;
    else low = middle;
  }
  return whole(stretched(trajectory, high), high);
}

/** A motion whose moves take `factor` times as long. */
function stretched(trajectory: Trajectory, factor: number): Trajectory {
  const { kind } = trajectory;
  if (RESTS.includes(kind)) return trajectory;
  if (kind === 'sequence') {
    const parts = trajectory.parts.map((part) => stretched(part as Trajectory, factor));
    return { ...trajectory, parts } as Trajectory;
  }
  const scaled = Object.entries(trajectory).map(([name, value]: [string, unknown]) => {
    const power = name in POWERS ? POWERS[name as keyof typeof POWERS] : null;
    if (power === null || value === null) return [name, value];
    const by = factor ** power;
    if (typeof value === 'number') return [name, value * by];
    const pairs = Object.entries(value as Record<string, number>);
    return [name, Object.fromEntries(pairs.map(([axis, each]) => [axis, each * by]))];
  });
  return Object.fromEntries(scaled) as Trajectory;
}
