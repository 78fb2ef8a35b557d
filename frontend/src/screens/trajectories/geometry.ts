/**
 * The curve of a drawn path, for drawing and for finding what is under the pointer. The server's is
 * the one that runs; this is the same centripetal cubic spline, so that it follows the hand at once.
 */

import type { DrawnPath, Point } from './drawn-path';

/** Corners of each edge at most. */
const SHARES = 16;

/**
 * Returns the curve as corners of a fine polyline, `apart` from each other, m, or as near as it gets,
 * and the edge of the path each belongs to.
 */
export function outline(
  { points, closed, geometry }: DrawnPath,
  apart = 0,
): {
  curve: Point[];
  edge: number[];
} {
  const corners = closed && points.length > 0 ? [...points, points[0] as Point] : [...points];
  if (geometry === 'polyline' || corners.length < 3) {
    return { curve: corners, edge: corners.map((_, i) => Math.min(i, corners.length - 2)) };
  }
  const steps = corners
    .slice(1)
    .map((point, i) => Math.sqrt(distance(point, corners[i] as Point)) || 1e-9);
  const moments = ([0, 1] as const).map((axis) =>
    curvatures(
      corners.map((corner) => corner[axis]),
      steps,
      closed,
    ),
  );
  const curve: Point[] = [];
  const edge: number[] = [];
  steps.forEach((h, i) => {
    const shares = Math.max(1, Math.min(SHARES, Math.ceil((h * h) / apart)));
    for (let k = 0; k < shares; k++) {
      const at = ([0, 1] as const).map((axis) => {
        const m = moments[axis] as number[];
        const [p, q] = [(corners[i] as Point)[axis], (corners[i + 1] as Point)[axis]];
        return cubic(p, q, m[i] as number, m[i + 1] as number, h, k / shares);
      });
      curve.push([at[0] as number, at[1] as number]);
      edge.push(i);
    }
  });
  curve.push(corners.at(-1) as Point);
  edge.push(steps.length - 1);
  return { curve, edge };
}

export function distance(a: Point, b: Point): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1]);
}

/** Returns the point of a segment that is nearest to a place. */
export function nearest(place: Point, a: Point, b: Point): Point {
  const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
  const squared = dx * dx + dy * dy;
  if (squared === 0) return a;
  const share = ((place[0] - a[0]) * dx + (place[1] - a[1]) * dy) / squared;
  const within = Math.min(1, Math.max(0, share));
  return [a[0] + within * dx, a[1] + within * dy];
}

/** Returns the index of the nearest point within `reach`, m, or null. */
export function pointAt(points: readonly Point[], place: Point, reach: number): number | null {
  let best: number | null = null;
  let least = reach;
  points.forEach((point, i) => {
    const away = distance(point, place);
    if (away > least) return;
    [best, least] = [i, away];
  });
  return best;
}

/** Returns the edge nearest to a place within `reach`, m, and where on it. */
export function edgeAt(
  path: DrawnPath,
  place: Point,
  reach: number,
): { edge: number; place: Point } | null {
  const { curve, edge } = outline(path);
  let found: { edge: number; place: Point } | null = null;
  let least = reach;
  for (let i = 0; i + 1 < curve.length; i++) {
    const close = nearest(place, curve[i] as Point, curve[i + 1] as Point);
    const away = distance(close, place);
    if (away > least) continue;
    least = away;
    found = { edge: edge[i] as number, place: close };
  }
  return found;
}

function cubic(p: number, q: number, m: number, n: number, h: number, share: number): number {
  const [a, b] = [1 - share, share];
  return a * p + b * q + ((a ** 3 - a) * m + (b ** 3 - b) * n) * ((h * h) / 6);
}

/** Returns the second derivatives of the interpolating spline at its knots. */
function curvatures(
  values: readonly number[],
  steps: readonly number[],
  closed: boolean,
): number[] {
  const n = steps.length;
  const slope = steps.map((h, i) => ((values[i + 1] as number) - (values[i] as number)) / h);
  const h = (i: number) => steps[(i + n) % n] as number;
  const jump = (i: number) => 6 * ((slope[i] as number) - (slope[(i - 1 + n) % n] as number));
  if (!closed) {
    const inner = Array.from({ length: n - 1 }, (_, i) => i + 1);
    const solved = tridiagonal(
      inner.map((i) => h(i - 1)),
      inner.map((i) => 2 * (h(i - 1) + h(i))),
      inner.map((i) => h(i)),
      inner.map(jump),
    );
    return [0, ...solved, 0];
  }
  // Sherman and Morrison: the corners of the cyclic equations as a change of rank one.
  const all = Array.from({ length: n }, (_, i) => i);
  const middle = all.map((i) => 2 * (h(i - 1) + h(i)));
  const gamma = -(middle[0] as number);
  const [corner, other] = [h(-1), h(n - 1)];
  const lower = all.map((i) => h(i - 1));
  const inner = [...middle];
  inner[0] = (middle[0] as number) - gamma;
  inner[n - 1] = (middle[n - 1] as number) - (corner * other) / gamma;
  const y = tridiagonal(lower, inner, steps, all.map(jump));
  const unit = all.map((i) => (i === 0 ? gamma : i === n - 1 ? other : 0));
  const z = tridiagonal(lower, inner, steps, unit);
  const ends = (v: number[]) => (v[0] as number) + (corner / gamma) * (v[n - 1] as number);
  const factor = ends(y) / (1 + ends(z));
  const solved = y.map((value, i) => value - factor * (z[i] as number));
  return [...solved, solved[0] as number];
}

function tridiagonal(
  lower: readonly number[],
  middle: readonly number[],
  upper: readonly number[],
  right: readonly number[],
): number[] {
  const n = middle.length;
  const factor: number[] = [];
  const result = [...right];
  let pivot = middle[0] as number;
  result[0] = (result[0] as number) / pivot;
  for (let i = 1; i < n; i++) {
    factor[i] = (upper[i - 1] as number) / pivot;
    pivot = (middle[i] as number) - (lower[i] as number) * (factor[i] as number);
    const before = result[i - 1] as number;
    result[i] = ((result[i] as number) - (lower[i] as number) * before) / pivot;
  }
  for (let i = n - 2; i >= 0; i--) {
    result[i] = (result[i] as number) - (factor[i + 1] as number) * (result[i + 1] as number);
  }
  return result;
}
