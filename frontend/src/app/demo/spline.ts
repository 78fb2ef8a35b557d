/** Curves through points by arc length, as trajectories/spline.py has them. */

import type { Curve } from './drawn-motion';
import type { MotionCode, Point, Rows } from './motion-code';

/** Nodes of a curve, and of one edge at least and at most. */
const NODES = 4096;
const NODES_PER_EDGE = [16, 256] as const;
/** Corners of a curve that is drawn, and of one edge at least and at most. */
const DRAWN = 2048;
const DRAWN_PER_EDGE = [4, 64] as const;
/** Gauss-Legendre, five points. */
const ABSCISSAE = [
  -0.906179845938664, -0.5384693101056831, 0, 0.5384693101056831, 0.906179845938664,
];
const WEIGHTS = [
  0.2369268850561891, 0.47862867049936647, 0.5688888888888889, 0.47862867049936647,
  0.2369268850561891,
];
/** Of the mean slope; below, the spline turns on the spot. */
const SLOWEST = 1e-9;

export function polyline(code: MotionCode, points: readonly Point[], closed: boolean): Curve {
  const corners = roundOf(points, closed);
  const edges = edgesOf(corners);
  const lengths = edges.map(([x, y]) => Math.hypot(x, y));
  const tangents = edges.map(([x, y], i): Point => [
    x / (lengths[i] as number),
    y / (lengths[i] as number),
  ]);
  const marks = sums(lengths);
  return { marks, path: (q) => code.along(corners, tangents, marks, within(q, marks, closed)) };
}

export function spline(
  code: MotionCode,
  points: readonly Point[],
  closed: boolean,
  breaks: readonly number[],
): Curve {
  const { knots, cubic } = fit(points, closed, breaks);
  const edges = knots.length - 1;
  const nodes = Math.min(Math.max(Math.floor(NODES / edges), NODES_PER_EDGE[0]), NODES_PER_EDGE[1]);
  const { arcLengths, parameters, pace } = table(code, cubic, knots, nodes);
  const marks = arcLengths.filter((_, i) => i % nodes === 0);
  return {
    marks,
    path: (q) =>
      code.follow(cubic, knots, nodes, arcLengths, parameters, pace, within(q, marks, closed)),
  };
}

/** Corners on the spline from end to end, for drawing, evenly spaced in the parameter, and the edge of each. */
export function outline(
  points: readonly Point[],
  closed: boolean,
  breaks: readonly number[],
): { places: Point[]; edges: number[] } {
  const { corners, knots, cubic } = fit(points, closed, breaks);
  const count = knots.length - 1;
  const [fewest, most] = DRAWN_PER_EDGE;
  const each = Math.min(Math.max(Math.floor(DRAWN / count), fewest), most);
  const places = Array.from({ length: count * each }, (_, k): Point => {
    const edge = Math.floor(k / each);
    const h = (knots[edge + 1] as number) - (knots[edge] as number);
    const u = (h * (k % each)) / each;
    const at = (axis: 0 | 1) =>
      cubic.reduceRight((sum, row) => sum * u + (row[edge] as Point)[axis], 0);
    return [at(0), at(1)];
  });
  const edges = places.map((_, k) => Math.floor(k / each));
  return { places: [...places, corners.at(-1) as Point], edges: [...edges, count - 1] };
}

/** The points once round, the parameter at each, and the cubic between them. */
function fit(points: readonly Point[], closed: boolean, breaks: readonly number[]) {
  const corners = roundOf(points, closed);
  const knots = sums(edgesOf(corners).map(([x, y]) => Math.sqrt(Math.hypot(x, y))));
  const edges = knots.length - 1;
  const ends = closed && breaks.length === 0 ? null : new Set([0, ...breaks, edges]);
  const second = [0, 1].map((axis) =>
    secondDerivatives(
      knots,
      corners.map((corner) => corner[axis] as number),
      ends,
    ),
  );
  return { corners, knots, cubic: coefficients(knots, corners, second) };
}

function roundOf(points: readonly Point[], closed: boolean): readonly Point[] {
  return closed ? [...points, points[0] as Point] : points;
}

function edgesOf(corners: readonly Point[]): Point[] {
  return corners.slice(1).map(([x, y], i) => {
    const [before, below] = corners[i] as Point;
    return [x - before, y - below];
  });
}

function sums(values: readonly number[]): Float64Array {
  const all = new Float64Array(values.length + 1);
  values.forEach((value, i) => (all[i + 1] = (all[i] as number) + value));
  return all;
}

/** Brings arc lengths of a closed path into its first lap. */
function within(q: Float64Array, marks: Float64Array, closed: boolean): Float64Array {
  const length = marks.at(-1) as number;
  if (!closed || q.every((each) => each >= 0 && each < length)) return q;
  return q.map((each) => ((each % length) + length) % length);
}

/**
 * The second derivatives M at the knots; with widths h and slopes d of the edges
 *
 *     h_{i-1} M_{i-1} + 2 (h_{i-1} + h_i) M_i + h_i M_{i+1} = 6 (d_i - d_{i-1})
 *
 * but at `ends`, which have none; without ends it is periodic.
 */
function secondDerivatives(
  knots: Float64Array,
  values: readonly number[],
  ends: ReadonlySet<number> | null,
): Float64Array {
  const count = knots.length - 1;
  const h = Array.from(
    { length: count },
    (_, i) => (knots[i + 1] as number) - (knots[i] as number),
  );
  const d = h.map((width, i) => ((values[i + 1] as number) - (values[i] as number)) / width);
  const row = (i: number) => {
    if (ends?.has(i)) return { low: 0, middle: 1, high: 0, right: 0 };
    const [before, after] = [(i + count - 1) % count, i % count];
    const [low, high] = [h[before] as number, h[after] as number];
    const right = 6 * ((d[after] as number) - (d[before] as number));
    return { low, middle: 2 * (low + high), high, right };
  };
  if (ends) return solved(Array.from({ length: count + 1 }, (_, i) => row(i)));
  // Periodic: the last knot is the first. With M_0 as a parameter the rest is tridiagonal.
  const inner = Array.from({ length: count - 1 }, (_, i) => row(i + 1));
  const free = solved(inner.map((each) => ({ ...each })));
  const unit = solved(
    inner.map((each, i) => {
      const first = i === 0 ? -each.low : 0;
      const last = i === count - 2 ? -each.high : 0;
      return { ...each, right: first + last };
    }),
  );
  const { low, middle, high, right } = row(0);
  const around = (M: Float64Array) => low * (M[count - 2] ?? 0) + high * (M[0] ?? 0);
  const first = (right - around(free)) / (middle + around(unit));
  const rest = free.map((each, i) => each + first * (unit[i] as number));
  return Float64Array.of(first, ...rest, first);
}

interface Row {
  low: number;
  middle: number;
  high: number;
  right: number;
}

/** Solves a tridiagonal system, whose first `low` and last `high` count for nothing. */
function solved(rows: Row[]): Float64Array {
  for (let i = 1; i < rows.length; i++) {
    const [before, own] = [rows[i - 1], rows[i]] as [Row, Row];
    const ratio = own.low / before.middle;
    own.middle -= ratio * before.high;
    own.right -= ratio * before.right;
  }
  const result = new Float64Array(rows.length);
  for (let i = rows.length - 1; i >= 0; i--) {
    const { middle, high, right } = rows[i] as Row;
    result[i] = (right - (i + 1 < rows.length ? high * (result[i + 1] as number) : 0)) / middle;
  }
  return result;
}

/** Coefficients of each edge by degree, constant first: (4, edges, 2). */
function coefficients(
  knots: Float64Array,
  corners: readonly Point[],
  second: readonly Float64Array[],
): Point[][] {
  const edges = Array.from({ length: knots.length - 1 }, (_, i) => i);
  const of = (degree: number) => (axis: 0 | 1, i: number) => {
    const h = (knots[i + 1] as number) - (knots[i] as number);
    const [M, next] = [second[axis]?.[i], second[axis]?.[i + 1]] as [number, number];
    const [here, there] = [corners[i]?.[axis], corners[i + 1]?.[axis]] as [number, number];
    const slope = (there - here) / h - (h * (2 * M + next)) / 6;
    return [here, slope, M / 2, (next - M) / (6 * h)][degree] as number;
  };
  return [0, 1, 2, 3].map((degree) =>
    edges.map((i): Point => [of(degree)(0, i), of(degree)(1, i)]),
  );
}

/** Arc length and parameter at nodes evenly spaced in each edge, and its slope on both sides of intervals. */
function table(
  { pace: paceAt }: MotionCode,
  cubic: Point[][],
  knots: Float64Array,
  nodes: number,
): { arcLengths: Float64Array; parameters: Float64Array; pace: Rows } {
  const count = (knots.length - 1) * nodes;
  const [arcLengths, parameters] = [new Float64Array(count + 1), new Float64Array(count + 1)];
  const slopes: [number, number][] = [];
  for (let edge = 0; edge < knots.length - 1; edge++) {
    const own = cubic.map((row) => Float64Array.from(row[edge] as Point));
    const begin = knots[edge] as number;
    const fine = ((knots[edge + 1] as number) - begin) / nodes;
    for (let k = 0; k < nodes; k++) {
      const i = edge * nodes + k;
      const arc = WEIGHTS.reduce(
        (sum, weight, j) =>
          sum + weight * paceAt(own, (k + 0.5 * (1 + (ABSCISSAE[j] as number))) * fine),
        0,
      );
      parameters[i] = begin + k * fine;
      arcLengths[i + 1] = (arcLengths[i] as number) + 0.5 * fine * arc;
      slopes.push([paceAt(own, k * fine), paceAt(own, (k + 1) * fine)]);
    }
  }
  parameters[count] = knots.at(-1) as number;
  const slowest = (SLOWEST * (arcLengths[count] as number)) / (knots.at(-1) as number);
  const pace = slopes.map((ends) =>
    Float64Array.from(ends, (slope) => 1 / Math.max(slope, slowest)),
  );
  return { arcLengths, parameters, pace };
}
