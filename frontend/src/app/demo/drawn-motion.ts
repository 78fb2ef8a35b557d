/** Drawn paths: curves by arc length, and their motion profiles, as trajectories/drawn_motion.py has them. */

import { Beyond } from '../whatif/changed-lanes';
import { byInstant, type Of, type Plan, ticksOf, times } from './motion';
import type { MotionCode, Piece, Point, Timing } from './motion-code';
import { polyline, spline } from './spline';

type Drawn = Omit<Of<'path'>, 'corners'> & { corners?: readonly number[] };
/** Arc length to a place with two derivatives, and the arc length at each point. */
export interface Curve {
  path: Piece['path'];
  marks: Float64Array;
}

const LAWS = ['minimum_jerk', 'trapezoid', 'jerk_limited'] as const;
/** Numbers that a law takes for a rest. */
const AT_REST = { minimum_jerk: [1], trapezoid: [1, 0], jerk_limited: [1, 1, 2] };

export function drawnPieces(
  code: MotionCode,
  config: Drawn,
  hold: (place: Point, seconds: number) => Piece[],
): Plan {
  if (config.law === 'time_optimal') {
    throw new Beyond('the page plans no time-optimal motion');
  }
  const { points, closed, corners = [] } = config as Drawn & { points: Point[] };
  const curve =
    config.geometry === 'polyline'
      ? polyline(code, points, closed)
      : spline(code, points, closed, corners);
  if (config.law === 'constant_speed') return atConstantSpeed(code, config, curve, hold);
  const lap = stopAndGo(code, config, config.law, curve);
  const pieces = [...hold(points[0] as Point, config.dwell), ...times([lap], config.laps)];
  if (!closed) return { pieces, period: 0, measured: 0 };
  return { pieces, period: lap.ticks, measured: Math.max(1, config.laps - 1) };
}

/** One lap that rests at its stops. */
function stopAndGo(
  code: MotionCode,
  config: Drawn,
  law: (typeof LAWS)[number],
  { path, marks }: Curve,
): Piece {
  const last = marks.length - 1;
  const numbers =
    config.geometry === 'polyline' ? [...marks.keys()] : [0, ...(config.corners ?? []), last];
  const stops = [...new Set(numbers)].sort((a, b) => a - b).map((k) => marks[k] as number);
  const ways = stops.slice(1).map((stop, i) => stop - (stops[i] as number));
  const roots = ways.reduce((total, way) => total + Math.sqrt(way), 0);
  const dwell = code.whole_ticks(config.dwell);
  const legs = ways.flatMap((way, i) => {
    const origin = stops[i] as number;
    const timing = code[law](config, way, Math.sqrt(way) / roots);
    const rest = { origin: origin + way, way: 0, timing: { numbers: AT_REST[law], ticks: dwell } };
    return [{ origin, way, timing }, ...(dwell > 0 ? [rest] : [])];
  });
  const column = (of: (leg: { origin: number; way: number; timing: Timing }) => number) =>
    Float64Array.from(legs, of);
  const begins = new Float64Array(legs.length + 1);
  legs.forEach(({ timing }, i) => (begins[i + 1] = (begins[i] as number) + timing.ticks));
  const [origins, lengths] = [column(({ origin }) => origin), column(({ way }) => way)];
  const timings = legs.map(({ timing }) => timing.numbers);
  return {
    path,
    law: (u) => code.on_legs(LAWS.indexOf(law), begins, origins, lengths, timings, u),
    ticks: begins[legs.length] as number,
    still: false,
    stretches: legs.map(({ way, timing }) => [timing.ticks, way === 0] as const),
  };
}

/** Start and stop lie on the path: n laps have n - 1 or fewer at full speed. */
function atConstantSpeed(
  code: MotionCode,
  config: Drawn,
  { path, marks }: Curve,
  hold: (place: Point, seconds: number) => Piece[],
): Plan {
  const length = marks.at(-1) as number;
  const whole = length * config.laps;
  let lap: number;
  let ramp: number;
  if (typeof config.lap_time === 'number') {
    lap = code.whole_ticks(config.lap_time);
    ramp = Math.max(1, Math.floor(lap / 2));
  } else {
    const [own, travel] = code.cruise_ticks(whole, config.v_max as number, config.a_max as number);
    [ramp, lap] = [own, Math.ceil(travel / config.laps)];
  }
  const rate = length / lap;
  const cruise = lap * config.laps - ramp;
  const [laps, remainder] = [Math.floor(cruise / lap), cruise % lap];
  const piece = (law: Piece['law'], ticks: number): Piece => ({ path, law, ticks, still: false });
  const faster = byInstant((u) => {
    const [clock, speed, gain] = code.smooth_start(u, ramp);
    return [rate * clock, rate * speed, rate * gain];
  });
  const cruising = byInstant((u) => [rate * (u + ramp / 2), rate, 0]);
  const slower = byInstant((u) => {
    const [clock, speed, gain] = code.smooth_start(ramp - u, ramp);
    return [whole - rate * clock, rate * speed, -rate * gain];
  });
  const [first, last] = [config.points[0], config.points.at(-1)] as [Point, Point];
  const rest = hold(first, config.dwell);
  const before = ticksOf(rest) + ramp;
  const pieces = [
    ...rest,
    piece(faster, ramp),
    ...times([piece(cruising, lap)], laps),
    ...(remainder > 0 ? [piece(cruising, remainder)] : []),
    piece(slower, ramp),
    ...hold(config.closed ? first : last, config.dwell),
  ];
  const measured = config.closed && laps > 0;
  return {
    pieces,
    period: 0,
    measured: 0,
    window: measured ? [before, before + laps * lap] : null,
  };
}
