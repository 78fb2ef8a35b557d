/** Where a path runs and what of it is under the pointer. */

import type { DrawnPath, Point } from './drawn-path';

/** Corners of a polyline, m, and the edge of the path that begins at, or contains, each. */
export interface Outline {
  x: ArrayLike<number>;
  y: ArrayLike<number>;
  edge: ArrayLike<number>;
}

/** Returns the straight edges between the points of a path. */
export function polygon({ points, closed }: DrawnPath): Outline {
  const corners = closed ? [...points, ...points.slice(0, 1)] : points;
  return {
    x: corners.map(([x]) => x),
    y: corners.map(([, y]) => y),
    edge: corners.map((_, i) => Math.min(i, corners.length - 2)),
  };
}

/**
 * Returns what a click on a path is held against: the curve that is drawn, or the straight edges
 * while that curve is one through more or fewer points.
 */
export function clickable(path: DrawnPath, drawn: Outline | null): Outline {
  const straight = polygon(path);
  const last = ({ edge }: Outline) => edge[edge.length - 1];
  return drawn && last(drawn) === last(straight) ? drawn : straight;
}

/** Returns the corners of an outline without those nearer to the one before than `least`, m; the last one stays. */
export function thinned({ x, y, edge }: Outline, least: number): Outline {
  const left: { x: number[]; y: number[]; edge: number[] } = { x: [], y: [], edge: [] };
  let [px, py] = [Number.POSITIVE_INFINITY, 0];
  for (let i = 0; i < x.length; i++) {
    const [cx, cy] = [x[i] as number, y[i] as number];
    if (i < x.length - 1 && Math.abs(cx - px) + Math.abs(cy - py) < least) continue;
    left.x.push(cx);
    left.y.push(cy);
    left.edge.push(edge[i] as number);
    [px, py] = [cx, cy];
  }
  return left;
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
  { x, y, edge }: Outline,
  place: Point,
  reach: number,
): { edge: number; place: Point } | null {
  const corner = (i: number): Point => [x[i] as number, y[i] as number];
  let hit: { edge: number; place: Point } | null = null;
  let least = reach;
  for (let i = 0; i + 1 < edge.length; i++) {
    const close = nearest(place, corner(i), corner(i + 1));
    const away = distance(close, place);
    if (away > least) continue;
    least = away;
    hit = { edge: edge[i] as number, place: close };
  }
  return hit;
}
