/** The module `motions.js` of a demo: motion profiles and curves, generated from the server's functions. */

export type Point = readonly [x: number, y: number];
/** x and y of each tick. */
export type Rows = Float64Array[];
/** A value and two derivatives. */
type Instant = [number, number, number];
type Law = [Float64Array, Float64Array, Float64Array];

/** One stretch of a motion: ticks to a path's parameter, and that to a place. */
export interface Piece {
  path: (q: Float64Array) => [Rows, Rows, Rows];
  law: (u: Float64Array) => Law;
  ticks: number;
  still: boolean;
  /** Of a piece that stops and goes on: ticks of each stretch, and whether it stands in it. */
  stretches?: readonly (readonly [ticks: number, still: boolean])[];
}

/** How a leg from rest to rest is timed: numbers of its law, and their sum. */
export interface Timing {
  numbers: number[];
  ticks: number;
}
type TimingOf = (config: object, way: number, share: number) => Timing;

export interface MotionCode {
  CONTROL_PERIOD: number;
  /** Largest jump between two ticks, m. */
  STEP_MAX: number;
  whole_ticks(seconds: number): number;
  chain_rule(
    slope: number,
    bend: number,
    rate: number,
    second: number,
  ): [velocity: number, acceleration: number];
  smooth_start(u: number, lead: number): Instant;
  minimum_jerk_at(u: number, duration: number): Instant;
  minimum_jerk_ticks(length: number, v_max: number, a_max: number): number;
  trapezoidal_at(u: number, ramp: number, cruise: number): Instant;
  trapezoidal_ticks(length: number, v_max: number, a_max: number): [ramp: number, cruise: number];
  cruise_ticks(length: number, v_max: number, a_max: number): [ramp: number, travel: number];
  minimum_jerk: TimingOf;
  trapezoid: TimingOf;
  jerk_limited: TimingOf;
  on_legs(
    law: number,
    begins: Float64Array,
    origins: Float64Array,
    ways: Float64Array,
    numbers: readonly number[][],
    u: Float64Array,
  ): Law;
  pace(cubic: Rows, u: number): number;
  along(
    corners: readonly Point[],
    tangents: readonly Point[],
    marks: Float64Array,
    q: Float64Array,
  ): [Rows, Rows, Rows];
  follow(
    cubic: readonly (readonly Point[])[],
    knots: Float64Array,
    nodes: number,
    arcLengths: Float64Array,
    parameters: Float64Array,
    pace: Rows,
    q: Float64Array,
  ): [Rows, Rows, Rows];
  /** The part of a displacement that the velocities at both ticks do not explain. */
  jump(way: number, now: number, before: number): number;
  /** The acceleration or, where it is larger, the one from the tick before. */
  mean_acceleration(acceleration: number, now: number, before: number): number;
}
