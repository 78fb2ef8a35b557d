/** Metrics of one axis of one variant: those of its tally, those of its holds. */

import type { Hold } from './lanes';

/** Share of a hold, at its end, over which the steady-state error is taken. */
const STEADY_TAIL = 0.2;
/** Below a picometre a move or an error at rest is rounding, m. */
const ROUNDING = 1e-12;

export type Figures = Record<string, number | null>;

/** Metrics of an axis that has none. */
export const NO_METRICS: Figures = Object.fromEntries(
  Object.keys({ ...tallyMetrics(() => 0, 1, 1), ...holdMetrics(() => 0, [], 0, 1) }).map((name) => [
    name,
    null,
  ]),
);

/**
 * Metrics of extremes and sums over `ticks` ticks.
 *
 * @param of a number of the tally by its name
 * @param period control period, s
 */
export function tallyMetrics(of: (name: string) => number, ticks: number, period: number): Figures {
  const rms = (name: string) => Math.sqrt(of(name) / ticks);
  return {
    max_abs_following_error: Math.max(-of('error_min'), of('error_max')),
    min_following_error: of('error_min'),
    max_following_error: of('error_max'),
    mean_following_error: of('error_sum') / ticks,
    rms_following_error: rms('error_squares'),
    itae: of('error_times') * period,
    max_abs_position_error: of('true_error_max'),
    max_abs_velocity: of('velocity_max'),
    rms_force: rms('thrust_squares'),
    max_abs_force: of('thrust_max'),
    rms_current: rms('current_squares'),
    max_current: of('current_max'),
    saturated_fraction: of('saturated') / ticks,
  };
}

/**
 * Metrics of the holds of a window; null without any.
 *
 * @param error following error at a tick of the window, m
 * @param band following error below which a move counts as settled, m
 */
export function holdMetrics(
  error: (tick: number) => number,
  holds: readonly Hold[],
  band: number,
  period: number,
): Figures {
  const none: Figures = {
    steady_state_error: null,
    settling_time: null,
    overshoot: null,
    relative_overshoot: null,
  };
  if (holds.length === 0) return none;
  const at = (tick: number) => {
    const e = error(tick);
    return Math.abs(e) < ROUNDING ? 0 : e;
  };
  let [steady, longest, overshoot, relative] = [0, 0, -1, -1];
  let settles = true;
  for (const [start, end, move] of holds) {
    const tail = end - Math.max(1, Math.round(STEADY_TAIL * (end - start)));
    let outside = start - 1;
    let beyond = 0;
    for (let tick = start; tick < end; tick++) {
      const e = at(tick);
      const size = Math.abs(e);
      if (size > band) outside = tick;
      if (tick >= tail && size > steady) steady = size;
      beyond = Math.max(beyond, -Math.sign(move) * e);
    }
    if (outside === end - 1) settles = false;
    longest = Math.max(longest, (outside + 1 - start) * period);
    if (Math.abs(move) > ROUNDING) {
      overshoot = Math.max(overshoot, beyond);
      relative = Math.max(relative, beyond / Math.abs(move));
    }
  }
  return {
    steady_state_error: steady,
    settling_time: settles ? longest : null,
    overshoot: overshoot < 0 ? null : overshoot,
    relative_overshoot: relative < 0 ? null : relative,
  };
}
