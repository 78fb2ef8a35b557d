/** What a path asks of the motor: the answer to POST /trajectories/check, as trajectory_check.py makes it; without thrust. */

import { AXES } from '../../kernel/module';
import type { Scenario } from '../api/types';
import type { MotionCode, Point } from './motion-code';
import { type Demand, demands, peakOf } from './motion-limits';
import { type Reference, sampled } from './reference';
import { outline } from './spline';

type Trajectory = Scenario['trajectory'];

/** Longest motion that is looked at, s. */
const LONGEST = 300;
/** Violations that are listed; the worst ones. */
const MOST = 50;
const UNCHECKED =
  'Whether its thrust suffices is not checked in a demo; a server does: ' +
  'pip install "motionlab[lab]", then motionlab serve';

export interface Column {
  name: string;
  unit: string;
  minimum: Float32Array;
  maximum: Float32Array;
}

interface Outside {
  demand: Demand;
  start: number;
  stop: number;
  worst: number;
}

/** One lap of a motion, if its laps repeat sample for sample, and how many there are. */
export function oneLap(trajectory: Trajectory): [one: Trajectory, laps: number] {
  const { kind } = trajectory;
  const repeats =
    kind === 'circle' ||
    kind === 'polygon' ||
    kind === 'star' ||
    (kind === 'path' && trajectory.law !== 'constant_speed');
  return repeats ? [{ ...trajectory, laps: 1 }, trajectory.laps] : [trajectory, 1];
}

/** @throws Beyond where the motion takes too long, or a server has to plan it */
export function motionOf(code: MotionCode, trajectory: Trajectory, longest = LONGEST): Reference {
  return sampled(code, trajectory, Math.round(longest / code.CONTROL_PERIOD));
}

/** Returns the head of the answer, its columns, and the curve of a smooth path. */
export function checkPath(
  code: MotionCode,
  trajectory: Trajectory,
  plant: Scenario['plant'],
  bins: number,
) {
  const [one, laps] = oneLap(trajectory);
  const reference = motionOf(code, one);
  const { ticks } = reference;
  const all = demands(code, reference, plant);
  const size = Math.max(1, Math.ceil(ticks / bins));
  const outside = all.flatMap(intervals).sort((a, b) => shareOf(b) - shareOf(a));
  const period = code.CONTROL_PERIOD;
  const head = {
    feasible: outside.length === 0,
    duration: (ticks + (laps - 1) * reference.period) * period,
    examined: ticks * period,
    length: lengthOf(reference),
    extent: extentOf(reference),
    time: { start: 0, step: size * period, count: Math.ceil(ticks / size) },
    peaks: all.map((demand) => {
      const { quantity, axis, unit, limit, values } = demand;
      const value = Math.abs(values[peakOf(demand)] as number);
      return { quantity, axis, value, limit, share: limit > 0 ? value / limit : null, unit };
    }),
    violations: outside.slice(0, MOST).map((each) => violation(each, reference, period)),
    violation_count: outside.length,
    notes: [UNCHECKED],
    thrust_reserve: 0,
  };
  return {
    head,
    columns: columnsOf(reference, all, size, period),
    outline:
      trajectory.kind === 'path' && trajectory.geometry === 'spline'
        ? outline(trajectory.points as Point[], trajectory.closed, trajectory.corners ?? [])
        : null,
  };
}

/** The answer in one piece: length of the head, 0, the head to a multiple of 8, columns as float32. */
export function packed({ head, columns, outline }: ReturnType<typeof checkPath>): ArrayBuffer {
  const { count } = head.time;
  const curves = columns.flatMap(({ minimum, maximum }) => [minimum, maximum]);
  const begin = curves.length * count;
  const corners = outline?.edges.length ?? 0;
  if (outline) {
    const { places, edges } = outline;
    curves.push(...[0, 1].map((axis) => Float32Array.from(places, (each) => each[axis] as number)));
    curves.push(Float32Array.from(edges));
  }
  const whole = {
    ...head,
    columns: columns.map(({ name, unit }, i) => {
      return { name, unit, minimum: 2 * i * count, maximum: (2 * i + 1) * count };
    }),
    outline: outline && {
      x: begin,
      y: begin + corners,
      edge: begin + 2 * corners,
      count: corners,
    },
    drawn: null,
  };
  const json = new TextEncoder().encode(JSON.stringify(whole));
  const length = 8 * Math.ceil(json.length / 8);
  const numbers = curves.reduce((sum, each) => sum + each.length, 0);
  const buffer = new ArrayBuffer(8 + length + 4 * numbers);
  new DataView(buffer).setUint32(0, length, true);
  new Uint8Array(buffer, 8, length).fill(0x20).set(json);
  const values = new Float32Array(buffer, 8 + length);
  let at = 0;
  for (const curve of curves) {
    values.set(curve, at);
    at += curve.length;
  }
  return buffer;
}

/** The stretches of ticks at which a quantity is too large. */
function intervals(demand: Demand): Outside[] {
  const { values, limit, slack } = demand;
  const all: Outside[] = [];
  values.forEach((value, k) => {
    if (Math.abs(value) <= limit + slack) return;
    const last = all.at(-1);
    if (last?.stop !== k) all.push({ demand, start: k, stop: k + 1, worst: k });
    else {
      last.stop = k + 1;
      if (Math.abs(value) > Math.abs(values[last.worst] as number)) last.worst = k;
    }
  });
  return all;
}

function shareOf({ demand: { values, limit }, worst }: Outside): number {
  return Math.abs(values[worst] as number) / limit;
}

function violation(
  { demand, start, stop, worst }: Outside,
  { columns, end, ticks }: Reference,
  period: number,
) {
  const { quantity, axis, unit, limit, values } = demand;
  return {
    quantity,
    axis,
    start: start * period,
    end: (stop - 1) * period,
    time: worst * period,
    place: AXES.map((_, i) => (worst < ticks ? columns[3 * i]?.[worst] : end[i]) as number),
    value: values[worst] as number,
    limit,
    unit,
  };
}

function lengthOf({ columns: [x, , , y], ticks }: Reference): number {
  const way = (row: Float64Array | undefined, k: number) =>
    (row?.[k] as number) - (row?.[k - 1] as number);
  let length = 0;
  for (let k = 1; k < ticks; k++) length += Math.hypot(way(x, k), way(y, k));
  return length;
}

function extentOf({ columns }: Reference): Record<string, [least: number, most: number]> {
  return Object.fromEntries(
    AXES.map((axis, i) => {
      const column = columns[3 * i] as Float64Array;
      const least = column.reduce((a, b) => Math.min(a, b), Number.POSITIVE_INFINITY);
      return [axis, [least, column.reduce((a, b) => Math.max(a, b), Number.NEGATIVE_INFINITY)]];
    }),
  );
}

/** Position, speed, jerk, velocity and acceleration, and the bits of what is too large, in bins. */
function columnsOf(
  { columns, ticks }: Reference,
  all: readonly Demand[],
  size: number,
  period: number,
): Column[] {
  const decimated = (name: string, unit: string, of: (k: number) => number): Column => {
    const count = Math.ceil(ticks / size);
    const [minimum, maximum] = [new Float32Array(count), new Float32Array(count)];
    for (let i = 0; i < count; i++) {
      let [low, high] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
      for (let k = i * size; k < Math.min((i + 1) * size, ticks); k++) {
        const value = of(k);
        [low, high] = [Math.min(low, value), Math.max(high, value)];
      }
      [minimum[i], maximum[i]] = [low, high];
    }
    return { name, unit, minimum, maximum };
  };
  const row = (i: number) => (k: number) => columns[i]?.[k] as number;
  const positions = AXES.map((axis, i): Column => {
    const first = Float32Array.from({ length: Math.ceil(ticks / size) }, (_, k) =>
      row(3 * i)(k * size),
    );
    return { name: `${axis}.position`, unit: 'm', minimum: first, maximum: first };
  });
  const speed = decimated('speed', 'm/s', (k) => Math.hypot(row(1)(k), row(4)(k)));
  const curves = AXES.flatMap((axis, i) => {
    const a = row(3 * i + 2);
    return [
      decimated(`${axis}.jerk`, 'm/s^3', (k) => (a(k) - (k > 0 ? a(k - 1) : 0)) / period),
      ...all
        .filter((each) => each.axis === axis && /^(velocity|acceleration)$/.test(each.quantity))
        .map(({ quantity, unit, values }) =>
          decimated(`${axis}.${quantity}`, unit, (k) => values[k] as number),
        ),
    ];
  });
  return [...positions, speed, ...curves, flags(all, size, ticks)];
}

function flags(all: readonly Demand[], size: number, ticks: number): Column {
  const shown = new Float32Array(Math.ceil(ticks / size));
  const names = [...new Set(all.map(({ quantity }) => quantity))];
  for (const { quantity, values, limit, slack } of all) {
    const bit = 1 << names.indexOf(quantity);
    values.forEach((value, k) => {
      // The end of the motion belongs to its last bin.
      const bin = Math.min(Math.floor(k / size), shown.length - 1);
      if (Math.abs(value) > limit + slack) shown[bin] = (shown[bin] as number) | bit;
    });
  }
  return { name: 'violated', unit: '1', minimum: shown, maximum: shown };
}
