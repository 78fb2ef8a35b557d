/** A stroke of a hand as points of a path. */

import type { Point } from './drawn-path';
import { distance, nearest } from './geometry';

/**
 * Returns the fewest points of a stroke from which none of the others is farther than `tolerance`
 * (Douglas and Peucker, Cartographica 1973).
 */
export function simplified(stroke: readonly Point[], tolerance: number): Point[] {
  const kept = new Set([0, stroke.length - 1]);
  const open: [number, number][] = [[0, stroke.length - 1]];
  for (let pair = open.pop(); pair; pair = open.pop()) {
    const [first, last] = pair;
    const [a, b] = [stroke[first] as Point, stroke[last] as Point];
    let [worst, farthest] = [-1, tolerance];
    for (let i = first + 1; i < last; i++) {
      const point = stroke[i] as Point;
      const away = distance(point, nearest(point, a, b));
      if (away > farthest) [worst, farthest] = [i, away];
    }
    if (worst < 0) continue;
    kept.add(worst);
    open.push([first, worst], [worst, last]);
  }
  return stroke.filter((_, i) => kept.has(i));
}

/**
 * Returns a stroke as points of a smooth path, and whether it came back to where it began, within
 * `reach`; too few for a path if the hand did not move.
 */
export function drawn(
  stroke: readonly Point[],
  tolerance: number,
  reach: number,
): { points: Point[]; closed: boolean } {
  const points = simplified(stroke, tolerance).map(([x, y]): Point => [micron(x), micron(y)]);
  const different = points.filter((point, i) => {
    const before = points[i - 1];
    return !before || point[0] !== before[0] || point[1] !== before[1];
  });
  const [first, last] = [different[0], different.at(-1)];
  const closed = different.length > 3 && !!first && !!last && distance(first, last) <= reach;
  return { points: closed ? different.slice(0, -1) : different, closed };
}

function micron(value: number): number {
  return Math.round(value * 1e6) / 1e6 + 0;
}
