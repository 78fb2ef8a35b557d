/** A scenario with another motion than the shipped one. */

import type { Lanes } from '../../kernel/lanes';
import { AXES, LANES } from '../../kernel/module';
import type { Scenario } from '../api/types';
import type { MotionCode } from './motion-code';
import { type Reference, sampled } from './reference';

/** Rows of the inputs that a motion decides. */
export const REFERENCE_ROWS = ['p_ref', 'v_ref', 'a_ref'] as const;

/** Longest motion, summed over variants, s: a worker's memory. */
const MOST = 60;

export interface Moved {
  lanes: Lanes;
  reference: Reference;
}

/**
 * Returns lanes with another motion in place of their own.
 *
 * @throws Beyond where it is too long, or a server has to plan it
 */
export function withMotion(
  code: MotionCode,
  lanes: Lanes,
  trajectory: Scenario['trajectory'],
  startRow: number,
): Moved {
  const variants = lanes.tabled.length;
  const most = Math.round(MOST / lanes.period / variants);
  const reference = sampled(code, trajectory, most);
  const { ticks, columns, window, holds, moving } = reference;
  const inputs = new Float64Array(columns.length * ticks);
  columns.forEach((column, i) => inputs.set(column, i * ticks));
  const state = lanes.state.slice();
  const states = state.length / (variants * LANES);
  for (let variant = 0; variant < variants; variant++) {
    AXES.forEach((_, lane) => {
      const place = (variant * states + startRow) * LANES + lane;
      state[place] = columns[REFERENCE_ROWS.length * lane]?.[0] as number;
    });
  }
  const [start, end] = window;
  const own = Object.fromEntries(moving.map((axis) => [axis, holds[axis]]));
  const moved = {
    ...lanes,
    keys: { ...lanes.keys, inputs: JSON.stringify(trajectory) },
    how: 'whole' as const,
    ticks,
    first: 0,
    stop: ticks,
    rows: AXES.flatMap((axis) => REFERENCE_ROWS.map((row): Lanes['rows'][number] => [row, axis])),
    inputs,
    state,
    moving,
    windows: lanes.windows.map((each) => ({
      ...each,
      start,
      end,
      holds: own,
      variants: Object.fromEntries(
        Object.entries(each.variants).map(([name, head]) => [name, { ...head, notes: [] }]),
      ),
    })),
  };
  return { lanes: moved, reference };
}
