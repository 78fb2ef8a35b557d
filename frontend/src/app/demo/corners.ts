/** Corners of motions of straight edges, as trajectories/corners.py has them. */

import type { Of } from './motion';
import type { Point } from './motion-code';

interface Pair {
  x: number;
  y: number;
}

export const xy = ({ x, y }: Pair): Point => [x, y];

/** The points at which a motion of straight edges stops, in order. */
export function corners(
  trajectory: Of<'line' | 'waypoints' | 'trapezoid' | 'staircase' | 'polygon' | 'star'>,
): Point[] {
  switch (trajectory.kind) {
    case 'polygon':
      return trajectory.vertices as Point[];
    case 'waypoints':
      return trajectory.points as Point[];
    case 'star': {
      const { center, circumradius, points, density, start_angle } = trajectory;
      return Array.from({ length: points }, (_, k) => {
        const angle = start_angle + (2 * Math.PI * ((k * density) % points)) / points;
        return [
          center.x + circumradius * Math.cos(angle),
          center.y + circumradius * Math.sin(angle),
        ];
      });
    }
    case 'staircase': {
      const { start, step, count, there_and_back } = trajectory;
      const up = Array.from({ length: count + 1 }, (_, k): Point => [
        start.x + k * step.x,
        start.y + k * step.y,
      ]);
      return there_and_back ? [...up, ...up.slice(0, -1).reverse()] : up;
    }
    default: {
      const [there, back] = [xy(trajectory.start), xy(trajectory.end)];
      if (trajectory.kind === 'line' || !trajectory.there_and_back) return [there, back];
      return [there, ...Array.from({ length: trajectory.cycles }, () => [back, there]).flat()];
    }
  }
}
