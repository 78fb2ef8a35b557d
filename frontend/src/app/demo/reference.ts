/** A motion by tick, with what metrics and feasibility take of it, as trajectories/reference.py has it. */

import type { Axis, Hold } from '../../kernel/lanes';
import { AXES } from '../../kernel/module';
import type { ProblemField, Scenario } from '../api/types';
import { Beyond } from '../whatif/changed-lanes';
import { placeAt, planMotion, SAME_PLACE, ticksOf } from './motion';
import type { MotionCode, Piece, Point } from './motion-code';

/** Ticks sampled at once. */
const BLOCK = 4096;
const POSITION_ROUNDING = 1e-12;
const ROUNDING = 1e-9;

export interface Reference {
  ticks: number;
  /** Position, velocity and acceleration of x, then of y. */
  columns: readonly Float64Array[];
  end: Point;
  moving: Axis[];
  window: [start: number, end: number];
  holds: Record<Axis, Hold[]>;
}

type Stretch = readonly [start: number, stop: number, still: boolean];

/** @throws Beyond where it has more ticks than `most`, or takes a server */
export function sampled(
  code: MotionCode,
  trajectory: Scenario['trajectory'],
  most: number,
): Reference {
  const { pieces, period, measured, window } = planMotion(code, trajectory);
  const ticks = ticksOf(pieces);
  // Before anything is allocated.
  if (ticks > most) throw new Beyond('the motion takes too long for the page');
  const columns = Array.from({ length: 3 * AXES.length }, () => new Float64Array(ticks));
  const starts = new Map<Piece, number>();
  let start = 0;
  for (const piece of pieces) {
    const before = starts.get(piece);
    if (before === undefined) sample(code, piece, columns, start);
    else for (const column of columns) column.copyWithin(start, before, before + piece.ticks);
    starts.set(piece, before ?? start);
    start += piece.ticks;
  }
  const last = pieces.at(-1) as Piece;
  const end = placeAt(last, last.ticks);
  const positions = AXES.map((_, i) => columns[3 * i] as Float64Array) as [
    Float64Array,
    Float64Array,
  ];
  const whole: [number, number] = [
    measured > 0 ? Math.max(ticks - period * measured, 0) : 0,
    ticks,
  ];
  const own = window ?? whole;
  const stretches = stretchesOf(pieces);
  return {
    ticks,
    columns,
    end,
    moving: AXES.filter((_, i) => {
      const extremes = positions[i] as Float64Array;
      const low = extremes.reduce((least, value) => Math.min(least, value), end[i] as number);
      return (
        extremes.reduce((most, value) => Math.max(most, value), end[i] as number) - low > SAME_PLACE
      );
    }),
    window: own,
    holds: Object.fromEntries(
      AXES.map((axis, i) => [axis, holdsWithin(stretches, positions, i, own)]),
    ) as Record<Axis, Hold[]>,
  };
}

function sample(code: MotionCode, piece: Piece, columns: readonly Float64Array[], start: number) {
  for (let begin = 0; begin < piece.ticks; begin += BLOCK) {
    const count = Math.min(BLOCK, piece.ticks - begin);
    const [q, rate, second] = piece.law(Float64Array.from({ length: count }, (_, k) => begin + k));
    const [place, slope, bend] = piece.path(q);
    const [velocity, acceleration] = code.chain_rule(slope, bend, rate, second);
    [place, velocity, acceleration].forEach((rows, row) => {
      rows.forEach((values, k) => {
        AXES.forEach((_, i) => {
          (columns[3 * i + row] as Float64Array)[start + begin + k] = values[i] as number;
        });
      });
    });
  }
}

function stretchesOf(pieces: readonly Piece[]): Stretch[] {
  let start = 0;
  return pieces.flatMap((piece) =>
    (piece.stretches ?? [[piece.ticks, piece.still] as const]).map(([ticks, still]): Stretch => {
      start += ticks;
      return [start - ticks, start, still];
    }),
  );
}

/** Standstills after moves that begin in a window, neighbours at one place joined. */
function holdsWithin(
  stretches: readonly Stretch[],
  positions: readonly [Float64Array, Float64Array],
  axis: number,
  [start, end]: readonly [number, number],
): Hold[] {
  const holds: [number, number][] = [];
  let stands: Point | null = null;
  for (const [first, stop, still] of stretches) {
    const place: Point | null = still
      ? [positions[0][first] as number, positions[1][first] as number]
      : null;
    if (place) {
      const before: Point | null = stands;
      const waits =
        before !== null &&
        place.every((each, i) => Math.abs(each - (before[i] as number)) <= SAME_PLACE);
      const last = holds.at(-1);
      if (!waits && first > 0) holds.push([first, stop]);
      else if (last?.[1] === first) last[1] = stop;
    }
    stands = place;
  }
  const from = new Map(
    stretches.filter(([, , still]) => !still).map(([first, stop]) => [stop, first]),
  );
  const position = positions[axis] as Float64Array;
  return holds
    .filter(([first]) => start <= first && first < end)
    .map(([first, stop]) => {
      const move = (position[first] as number) - (position[from.get(first) ?? first - 1] as number);
      return [first - start, Math.min(stop, end) - start, move];
    });
}

/** What of a motion exceeds stroke, steps, velocity or acceleration of its motor; thrust is not looked at. */
export function infeasible(
  code: MotionCode,
  { columns, end, ticks }: Reference,
  plant: Scenario['plant'],
): ProblemField[] {
  return AXES.flatMap((axis, i) => {
    const [p, v, a] = columns.slice(3 * i, 3 * i + 3) as [Float64Array, Float64Array, Float64Array];
    const { stroke, velocity_max, acceleration_max } = plant[axis];
    let [position, step, velocity, acceleration] = [Math.abs(end[i] as number), 0, 0, 0];
    for (let k = 0; k < ticks; k++) {
      const [now, before] = [v[k] as number, k > 0 ? (v[k - 1] as number) : 0];
      const way = k > 0 ? (p[k] as number) - (p[k - 1] as number) : 0;
      position = Math.max(position, Math.abs(p[k] as number));
      if (k > 0) step = Math.max(step, Math.abs(code.jump(way, now, before)));
      velocity = Math.max(velocity, Math.abs(now));
      const own = code.mean_acceleration(a[k] as number, now, before);
      acceleration = Math.max(acceleration, Math.abs(own));
    }
    const limits = [
      ['position', position, stroke, 'm', POSITION_ROUNDING],
      ['a step', step, code.STEP_MAX, 'm', POSITION_ROUNDING],
      ['velocity', velocity, velocity_max, 'm/s', ROUNDING * velocity_max],
      ['acceleration', acceleration, acceleration_max, 'm/s^2', ROUNDING * acceleration_max],
    ] as const;
    return limits.flatMap(([name, value, maximum, unit, slack]) => {
      if (value <= maximum + slack) return [];
      const message = `${name} of ${axis} exceeds the motor's`;
      return [{ loc: 'trajectory', message, value, bounds: { maximum }, unit }];
    });
  });
}
