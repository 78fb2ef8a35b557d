/** A motion by tick, with what metrics and feasibility take of it, as trajectories/reference.py has it. */

import type { Axis, Hold } from '../../kernel/lanes';
import { AXES } from '../../kernel/module';
import type { Scenario } from '../api/types';
import { Beyond } from '../whatif/changed-lanes';
import { placeAt, planMotion, SAME_PLACE, ticksOf } from './motion';
import type { MotionCode, Piece, Point } from './motion-code';

/** Ticks sampled at once. */
const BLOCK = 4096;

export interface Reference {
  ticks: number;
  /** Ticks of a lap that repeats; 0 where none does. */
  period: number;
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
    period,
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
    place.forEach((position, k) => {
      AXES.forEach((_, i) => {
        const along = [slope[k]?.[i], bend[k]?.[i], rate[k], second[k]] as Parameters<
          MotionCode['chain_rule']
        >;
        [position[i] as number, ...code.chain_rule(...along)].forEach((value, row) => {
          (columns[3 * i + row] as Float64Array)[start + begin + k] = value;
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
