/** What is done to several points at once; all in SI, nothing in place. */

import { withPlaces, type DrawnPath, type Point } from './drawn-path';

export interface Bounds {
  west: number;
  east: number;
  south: number;
  north: number;
}

export type Chosen = ReadonlySet<number>;
/** Nothing, or the points of some indices in that order. */
export function chosenOf(indices: Iterable<number> = []): Chosen {
  return new Set(indices);
}

export type Side = 'west' | 'middle' | 'east' | 'south' | 'centre' | 'north';

/** Returns the smallest box around some points of a path. */
export function boundsOf({ points }: DrawnPath, chosen: Chosen): Bounds {
  const bounds = {
    west: Number.POSITIVE_INFINITY,
    east: Number.NEGATIVE_INFINITY,
    south: Number.POSITIVE_INFINITY,
    north: Number.NEGATIVE_INFINITY,
  };
  for (const index of chosen) {
    const [x, y] = points[index] ?? [Number.NaN, Number.NaN];
    if (Number.isNaN(x)) continue;
    bounds.west = Math.min(bounds.west, x);
    bounds.east = Math.max(bounds.east, x);
    bounds.south = Math.min(bounds.south, y);
    bounds.north = Math.max(bounds.north, y);
  }
  return bounds;
}

export function centreOf({ west, east, south, north }: Bounds): Point {
  return [(west + east) / 2, (south + north) / 2];
}

/** Returns the points within a box of which two corners are given. */
export function within({ points }: DrawnPath, [ax, ay]: Point, [bx, by]: Point): number[] {
  const [west, east] = [Math.min(ax, bx), Math.max(ax, bx)];
  const [south, north] = [Math.min(ay, by), Math.max(ay, by)];
  return points.flatMap(([x, y], i) =>
    x >= west && x <= east && y >= south && y <= north ? [i] : [],
  );
}

export function movedBy(path: DrawnPath, chosen: Chosen, [dx, dy]: Point): DrawnPath {
  return withPlaces(path, chosen, ([x, y]) => [x + dx, y + dy]);
}

/** Returns the path with some points scaled about the middle of their box; -1 mirrors. */
export function scaled(path: DrawnPath, chosen: Chosen, [sx, sy]: Point): DrawnPath {
  const [cx, cy] = centreOf(boundsOf(path, chosen));
  return withPlaces(path, chosen, ([x, y]) => [cx + sx * (x - cx), cy + sy * (y - cy)]);
}

/** Returns the path with some points turned to the left about the middle of their box, rad. */
export function rotated(path: DrawnPath, chosen: Chosen, angle: number): DrawnPath {
  const [cx, cy] = centreOf(boundsOf(path, chosen));
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return withPlaces(path, chosen, ([x, y]) => [
    cx + c * (x - cx) - s * (y - cy),
    cy + s * (x - cx) + c * (y - cy),
  ]);
}

/** Returns the path with some points on one line: a side of their box or its middle. */
export function aligned(path: DrawnPath, chosen: Chosen, side: Side): DrawnPath {
  const bounds = boundsOf(path, chosen);
  const [cx, cy] = centreOf(bounds);
  return withPlaces(path, chosen, ([x, y]) => {
    switch (side) {
      case 'west':
      case 'east':
        return [bounds[side], y];
      case 'middle':
        return [cx, y];
      case 'south':
      case 'north':
        return [x, bounds[side]];
      case 'centre':
        return [x, cy];
      default:
        return side satisfies never;
    }
  });
}

/** Returns the path with some points at equal distances along an axis, in the order they lie. */
export function distributed(path: DrawnPath, chosen: Chosen, axis: 0 | 1): DrawnPath {
  const at = (index: number) => path.points[index]?.[axis] ?? 0;
  const order = [...chosen].sort((a, b) => at(a) - at(b));
  if (order.length < 3) return path;
  const [first, last] = [at(order[0] ?? 0), at(order.at(-1) ?? 0)];
  const places = new Map(
    order.map((index, k) => [
      path.points[index],
      first + ((last - first) * k) / (order.length - 1),
    ]),
  );
  return withPlaces(path, chosen, (point) => {
    const to = places.get(point) ?? point[axis];
    return axis === 0 ? [to, point[1]] : [point[0], to];
  });
}
