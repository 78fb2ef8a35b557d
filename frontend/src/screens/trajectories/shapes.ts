/** Paths to start from, and figures turned into points. */

import { numberAt } from '../../app/api/scenario-paths';
import { clean } from '../../ui/units';
import { newPath, type DrawnPath, type Point, type Table } from './drawn-path';

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

/**
 * Returns a figure as an editable path with the same corners and about the same time, or null for a
 * kind that has none.
 */
export function converted(table: Table): DrawnPath | null {
  const number = (path: string, fallback = 0) => {
    const value = numberAt(table, path);
    return Number.isFinite(value) ? value : fallback;
  };
  const about = (points: readonly Point[]): Point[] =>
    points.map(([x, y]) => [tidy(x + number('center.x')), tidy(y + number('center.y'))]);
  const lap = (path: DrawnPath): DrawnPath => ({
    ...path,
    v_max: null,
    a_max: null,
    lap_time: clean(1 / number('frequency', 1)),
    laps: number('laps', 1),
  });
  const listed = (value: unknown) => (value as [number, number][]).map(([x, y]): Point => [x, y]);
  const start: Point = [number('start.x'), number('start.y')];
  const timing = {
    v_max: number('v_max') || null,
    a_max: number('a_max') || null,
    dwell: number('dwell'),
  };
  switch (table.kind) {
    case 'circle': {
      const turn = table.direction === 'cw' ? -1 : 1;
      const points = ring(ROUND, number('radius'), number('start_angle'), turn);
      const path = lap(newPath(about(points), true));
      return { ...path, geometry: 'spline', law: 'constant_speed' };
    }
    case 'polygon':
      return lap(newPath(listed(table.vertices), true));
    case 'star': {
      const points = ring(
        number('points', 5),
        number('circumradius'),
        number('start_angle', Math.PI / 2),
        number('density', 2),
      );
      return lap(newPath(about(points), true));
    }
    case 'waypoints':
    case 'line': {
      const points = table.kind === 'line' ? [start, endOf(table)] : listed(table.points);
      const path = { ...newPath(points, false), ...timing };
      const edge = number('edge_time');
      const total = clean(edge * (points.length - 1));
      return edge > 0 ? { ...path, v_max: null, a_max: null, lap_time: total } : path;
    }
    case 'trapezoid': {
      const there = [start, endOf(table)];
      const path = {
        ...newPath(table.there_and_back === false ? there : [...there, start], false),
      };
      return { ...path, ...timing, law: 'trapezoid' };
    }
    case 'staircase': {
      const count = number('count', 1);
      const up = Array.from({ length: count + 1 }, (_, k): Point => {
        return [tidy(start[0] + k * number('step.x')), tidy(start[1] + k * number('step.y'))];
      });
      const points = table.there_and_back === false ? up : [...up, ...up.slice(0, -1).reverse()];
      if (timing.v_max === null) return null;
      return { ...newPath(points, false), ...timing, law: 'trapezoid' };
    }
    default:
      return null;
  }
}

function endOf(table: Table): Point {
  return [numberAt(table, 'end.x') || 0, numberAt(table, 'end.y') || 0];
}

/** Rounds to a nanometre, and minus zero to zero. */
function tidy(value: number): number {
  return clean(Math.round(value * 1e9) / 1e9) + 0;
}
