/** Paths to start from. */

import { clean } from '../../ui/units';
import { newPath, type DrawnPath, type Point } from './drawn-path';

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
