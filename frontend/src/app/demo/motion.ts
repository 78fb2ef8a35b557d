/** Motions as pieces, sampled by tick: what trajectories/pieces.py makes of a config. */

import type { Scenario } from '../api/types';
import { Beyond } from '../whatif/changed-lanes';
import { corners, xy } from './corners';
import { drawnPieces } from './drawn-motion';
import type { MotionCode, Piece, Point, Rows } from './motion-code';

type Trajectory = Scenario['trajectory'];
export type Of<Kind extends string> = Extract<Trajectory, { kind: Kind }>;

export interface Plan {
  pieces: Piece[];
  /** Ticks of a lap, and how many at the end metrics use: 0 for all. */
  period: number;
  measured: number;
  window?: [number, number] | null;
}

/** Longest motion, s. */
const LONGEST = 3600;
const MOVES_MAX = 1_000_000;
/** Below, two positions differ by rounding only, m. */
export const SAME_PLACE = 1e-12;

const once = (pieces: Piece[]): Plan => ({ pieces, period: 0, measured: 0 });

/** @throws Beyond where it takes more than this page has */
export function planMotion(code: MotionCode, trajectory: Trajectory): Plan {
  const build = new Pieces(code);
  switch (trajectory.kind) {
    case 'point':
      return once(build.hold(xy(trajectory.position), trajectory.duration));
    case 'dwell':
      return once(build.hold([0, 0], trajectory.duration));
    case 'step': {
      const [start, height] = [xy(trajectory.start), xy(trajectory.height)];
      const top: Point = [start[0] + height[0], start[1] + height[1]];
      return once([...build.hold(start, trajectory.delay), ...build.hold(top, trajectory.dwell)]);
    }
    case 'ramp': {
      const { start, velocity, duration, lead_in } = trajectory;
      const path = ray(xy(start), xy(velocity));
      return once([build.timed(path, duration, lead_in)]);
    }
    case 'parabola': {
      const [start, half] = [xy(trajectory.start), xy(trajectory.coefficient)];
      const path = alongAxes((axis, q) => [
        start[axis] + half[axis] * q ** 2,
        2 * half[axis] * q,
        2 * half[axis],
      ]);
      return once([build.timed(path, trajectory.duration, 0)]);
    }
    case 'sine':
    case 'circle':
      return build.turning(trajectory);
    case 'line':
    case 'waypoints':
    case 'trapezoid':
    case 'staircase': {
      const points = corners(trajectory);
      const pieces = build.pointToPoint(points, trajectory.dwell, build.edgeRule(trajectory));
      const laps = 'laps' in trajectory ? trajectory.laps : 1;
      return build.repeated(pieces, laps, trajectory.dwell);
    }
    case 'polygon':
    case 'star':
      return build.closed(trajectory);
    case 'path':
      return drawnPieces(code, trajectory, (place, seconds) => build.hold(place, seconds));
    case 'sequence': {
      const pieces: Piece[] = [];
      for (const part of trajectory.parts) {
        const last = pieces.at(-1);
        const own = planMotion(code, part as Trajectory).pieces;
        if (!last) pieces.push(...own);
        else {
          const [end, begin] = [placeAt(last, last.ticks), placeAt(own[0] as Piece, 0)];
          const offset: Point = [end[0] - begin[0], end[1] - begin[1]];
          const moved = new Map(own.map((piece) => [piece, shifted(piece, offset)]));
          pieces.push(...own.map((piece) => moved.get(piece) as Piece));
        }
      }
      return build.repeated(pieces, trajectory.laps, 0);
    }
    case 'samples':
      throw new Beyond('the page interpolates no samples');
    case 'multisine':
      throw new Beyond('the page draws no phases of a multisine');
  }
}

/** The position at a tick of a piece. */
export function placeAt(piece: Piece, tick: number): Point {
  const [place] = piece.path(piece.law(Float64Array.of(tick))[0]);
  return [...(place[0] as Float64Array)] as unknown as Point;
}

function shifted(piece: Piece, [x, y]: Point): Piece {
  const path: Piece['path'] = (q) => {
    const [place, slope, bend] = piece.path(q);
    const moved = place.map((each) =>
      Float64Array.of((each[0] as number) + x, (each[1] as number) + y),
    );
    return [moved, slope, bend];
  };
  return { ...piece, path };
}

/** A path whose axes are functions of the parameter: value and two derivatives. */
function alongAxes(
  of: (axis: 0 | 1, q: number) => readonly [number, number, number],
): Piece['path'] {
  return (q) => {
    const all = Array.from(q, (each) => [of(0, each), of(1, each)] as const);
    const rows = (k: 0 | 1 | 2): Rows => all.map(([x, y]) => Float64Array.of(x[k], y[k]));
    return [rows(0), rows(1), rows(2)];
  };
}

function ray(start: Point, direction: Point): Piece['path'] {
  return alongAxes((axis, q) => [start[axis] + direction[axis] * q, direction[axis], 0]);
}

function line(start: Point, end: Point): Piece['path'] {
  return ray(start, [end[0] - start[0], end[1] - start[1]]);
}

/** A law of single instants. */
export function byInstant(of: (u: number) => readonly [number, number, number]): Piece['law'] {
  return (u) => {
    const all = Array.from(u, of);
    const row = (k: 0 | 1 | 2) => Float64Array.from(all, (each) => each[k]);
    return [row(0), row(1), row(2)];
  };
}

type EdgeRule = (start: Point, end: Point) => Piece;

class Pieces {
  constructor(private readonly code: MotionCode) {}

  hold(place: Point, seconds: number): Piece[] {
    const ticks = this.code.whole_ticks(seconds);
    if (ticks === 0) return [];
    return [{ path: ray(place, [0, 0]), law: byInstant((u) => [u, 1, 0]), ticks, still: true }];
  }

  /** Runs along a path whose parameter grows by `rate` a tick once the lead-in has passed. */
  private run(path: Piece['path'], rate: number, lead: number, ticks: number): Piece {
    const law = byInstant((u) => {
      const [clock, speed, gain] = this.code.smooth_start(u, lead);
      return [rate * clock, rate * speed, rate * gain];
    });
    return { path, law, ticks, still: false };
  }

  timed(path: Piece['path'], seconds: number, lead: number): Piece {
    const { whole_ticks, CONTROL_PERIOD } = this.code;
    return this.run(path, CONTROL_PERIOD, whole_ticks(lead), whole_ticks(seconds));
  }

  /** Laps of a sine or circle, at full speed at the end or eased to rest. */
  turning(trajectory: Of<'sine' | 'circle'>): Plan {
    const { code } = this;
    const { frequency, lead_in, center, for_ever } = trajectory;
    const lap = code.whole_ticks(1 / frequency);
    const lead = code.whole_ticks(lead_in ?? 0.5 / frequency);
    const round = trajectory.kind === 'circle';
    const laps = round ? trajectory.laps : trajectory.cycles;
    const [size, phase] = round
      ? [
          [trajectory.radius, trajectory.radius],
          [trajectory.start_angle + Math.PI / 2, trajectory.start_angle],
        ]
      : [xy(trajectory.amplitude), xy(trajectory.phase)];
    const path = alongAxes((axis, q) => {
      const angle = q + (phase[axis] as number);
      const [sine, cosine] = [Math.sin(angle), Math.cos(angle)].map(
        (each) => (size[axis] as number) * each,
      ) as [number, number];
      return [xy(center)[axis] + sine, cosine, -sine];
    });
    const rate = round
      ? ((trajectory.direction === 'ccw' ? 1 : -1) * 2 * Math.PI) / lap
      : 2 * Math.PI * frequency * code.CONTROL_PERIOD;
    const ticks = lead + (round ? laps * lap : code.whole_ticks(laps / frequency));
    this.refuseTooLong(ticks);
    const turning = this.run(path, rate, lead, ticks);
    const lastTwo = Math.max(1, Math.min(2, laps - 1));
    if (for_ever) return { pieces: [turning], period: lap, measured: lastTwo };
    const window: [number, number] = [ticks - Math.min(lastTwo * lap, ticks), ticks];
    const pieces = lead > 0 ? [turning, this.easeOut(turning, rate, lead)] : [turning];
    return { pieces, period: lap, measured: 0, window };
  }

  private easeOut({ path, law, ticks: end }: Piece, rate: number, ticks: number): Piece {
    const begin = law(Float64Array.of(end))[0][0] as number;
    const [whole] = this.code.smooth_start(ticks, ticks);
    const slower = byInstant((u) => {
      const [clock, speed, gain] = this.code.smooth_start(ticks - u, ticks);
      return [begin + rate * (whole - clock), rate * speed, -rate * gain];
    });
    return { path, law: slower, ticks, still: false };
  }

  edgeRule(trajectory: Of<'line' | 'waypoints' | 'trapezoid' | 'staircase'>): EdgeRule | null {
    const { code } = this;
    const { v_max, a_max } = trajectory;
    const time = 'edge_time' in trajectory ? trajectory.edge_time : null;
    if (typeof time === 'number') {
      return (start, end) => this.minimumJerk(start, end, code.whole_ticks(time));
    }
    if (typeof v_max !== 'number' || typeof a_max !== 'number') return null;
    const length = (start: Point, end: Point) => Math.hypot(end[0] - start[0], end[1] - start[1]);
    if (trajectory.kind === 'line' || trajectory.kind === 'waypoints') {
      return (start, end) =>
        this.minimumJerk(start, end, code.minimum_jerk_ticks(length(start, end), v_max, a_max));
    }
    return (start, end) => {
      const [ramp, cruise] = code.trapezoidal_ticks(length(start, end), v_max, a_max);
      const law = byInstant((u) => code.trapezoidal_at(u, ramp, cruise));
      return { path: line(start, end), law, ticks: 2 * ramp + cruise, still: false };
    };
  }

  private minimumJerk(start: Point, end: Point, ticks: number): Piece {
    const law = byInstant((u) => this.code.minimum_jerk_at(u, ticks));
    return { path: line(start, end), law, ticks, still: false };
  }

  /** Stands at each point in turn, joined by edges, or by jumps where there is no rule for them. */
  pointToPoint(points: readonly Point[], dwell: number, edge: EdgeRule | null): Piece[] {
    return points.flatMap((point, i) => {
      const before = points[i - 1];
      return [...(edge && before ? [edge(before, point)] : []), ...this.hold(point, dwell)];
    });
  }

  closed(trajectory: Of<'polygon' | 'star'>): Plan {
    const points = corners(trajectory);
    const { frequency, dwell, laps } = trajectory;
    const ticks = this.code.whole_ticks(1 / (frequency * points.length));
    const lap = points.flatMap((start, i) => {
      const end = points[(i + 1) % points.length] as Point;
      return [this.minimumJerk(start, end, ticks), ...this.hold(end, dwell)];
    });
    const period = ticksOf(lap);
    this.refuseTooLong(period * laps);
    const pieces = [...this.hold(points[0] as Point, dwell), ...times(lap, laps)];
    return { pieces, period, measured: Math.max(1, laps - 1) };
  }

  /** Repeats a motion that ends where it starts; it stands once only between two laps. */
  repeated(pieces: Piece[], laps: number, dwell: number): Plan {
    if (laps === 1) return once(pieces);
    const before = dwell > 0 ? 1 : 0;
    const lap = pieces.slice(before);
    const last = pieces.at(-1) as Piece;
    const [begin, end] = [placeAt(pieces[0] as Piece, 0), placeAt(last, last.ticks)];
    if (Math.max(Math.abs(end[0] - begin[0]), Math.abs(end[1] - begin[1])) > SAME_PLACE) {
      throw new Beyond('more than one lap needs an end where the motion starts');
    }
    this.refuseTooLong(ticksOf(lap) * laps);
    if (lap.length * laps > MOVES_MAX) throw new Beyond('the motion has too many moves');
    return {
      pieces: [...pieces.slice(0, before), ...times(lap, laps)],
      period: ticksOf(lap),
      measured: laps - 1,
    };
  }

  private refuseTooLong(ticks: number): void {
    if (ticks * this.code.CONTROL_PERIOD > LONGEST) throw new Beyond('the motion lasts too long');
  }
}

export function ticksOf(pieces: readonly Piece[]): number {
  return pieces.reduce((total, { ticks }) => total + ticks, 0);
}

export function times<T>(items: readonly T[], count: number): T[] {
  return Array.from({ length: count }, () => items).flat();
}
