/** Paths to start from, and strokes of a hand as points of a path. */

import { clean } from '../../ui/units';
import { type DrawnPath, newPath, type Point } from './drawn-path';
import { distance, nearest } from './geometry';

export type Shape = 'empty' | 'line' | 'rhombus' | 'square' | 'star' | 'circle' | 'wave';

export const SHAPES: readonly { shape: Shape; name: string }[] = [
  { shape: 'empty', name: 'nothing' },
  { shape: 'line', name: 'line' },
  { shape: 'rhombus', name: 'rhombus' },
  { shape: 'square', name: 'square' },
  { shape: 'star', name: 'star' },
  { shape: 'circle', name: 'circle, 12 points' },
  { shape: 'wave', name: 'wave' },
];

const ROUND = 12;
const RADIUS = 0.03;

/** Returns points on a circle, every `stride`-th of `count` in turn. */
export function ring(count: number, radius: number, start: number, stride = 1): Point[] {
  return Array.from({ length: count }, (_, i): Point => {
    const angle = start + (2 * Math.PI * i * stride) / count;
    return [tidy(radius * Math.cos(angle)), tidy(radius * Math.sin(angle))];
  });
}

export function shape(which: Shape): DrawnPath {
  switch (which) {
    case 'empty':
      return newPath([], false);
    case 'line':
      return newPath(
        [
          [-0.03, 0],
          [0.03, 0],
        ],
        false,
      );
    case 'rhombus':
      return newPath(ring(4, RADIUS, 0), true);
    case 'square':
      return newPath(
        [
          [0.02, 0.02],
          [-0.02, 0.02],
          [-0.02, -0.02],
          [0.02, -0.02],
        ],
        true,
      );
    case 'star':
      return newPath(ring(5, RADIUS, Math.PI / 2, 2), true);
    case 'circle':
      return { ...newPath(ring(ROUND, RADIUS, 0), true), geometry: 'spline' };
    case 'wave':
      return {
        ...newPath(
          Array.from({ length: 9 }, (_, i): Point => {
            return [tidy(-0.06 + 0.015 * i), tidy(0.02 * Math.sin((Math.PI / 2) * i))];
          }),
          false,
        ),
        geometry: 'spline',
      };
    default:
      return which satisfies never;
  }
}

/** Rounds to a nanometre, and minus zero to zero. */
function tidy(value: number): number {
  return clean(Math.round(value * 1e9) / 1e9) + 0;
}

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
