import { describe, expect, it } from 'vitest';
import { newPath, type Point } from './drawn-path';
import { clickable, edgeAt, nearest, pointAt, polygon, thinned } from './geometry';
import { ring, shape, SHAPES } from './shapes';

const SQUARE = newPath(ring(4, 0.03, 0), true);

it('a polygon ends at its first point where it is closed', () => {
  const { points } = SQUARE;
  const corners = (closed: boolean) => {
    const { x, y, edge } = polygon({ ...SQUARE, closed });
    return Array.from(x, (_, i) => [x[i], y[i], edge[i]]);
  };
  const [a, b, c, d] = points as [Point, Point, Point, Point];
  expect(corners(false)).toEqual([
    [...a, 0],
    [...b, 1],
    [...c, 2],
    [...d, 2],
  ]);
  expect(corners(true)).toEqual([
    [...a, 0],
    [...b, 1],
    [...c, 2],
    [...d, 3],
    [...a, 3],
  ]);
});

it('thinning keeps the ends, and nothing nearer than asked to the corner before', () => {
  const x = [0, 0.2, 0.9, 1.1, 1.3, 2.5, 2.6];
  const outline = { x, y: x.map(() => 0), edge: x.map((_, i) => i) };
  expect(thinned(outline, 1)).toEqual({
    x: [0, 1.1, 2.5, 2.6],
    y: [0, 0, 0, 0],
    edge: [0, 3, 5, 6],
  });
  expect(thinned(outline, 0)).toEqual(outline);
});

it('a click is held against the curve, but not one through fewer points', () => {
  const curve = { x: [0.03, 0, 0.03], y: [0, 0.03, 0], edge: [0, 3, 3] };
  expect(clickable(SQUARE, curve)).toBe(curve);
  expect(clickable({ ...SQUARE, closed: false }, curve).edge).toHaveLength(4);
  expect(clickable(SQUARE, null).edge).toHaveLength(5);
});

describe('what is under the pointer', () => {
  it('is the nearest point within reach', () => {
    const points = ring(4, 0.03, 0);
    expect(pointAt(points, [0.0295, 0.0001], 0.001)).toBe(0);
    expect(pointAt(points, [0.02, 0], 0.001)).toBeNull();
  });

  it('is an edge and the place on it', () => {
    expect(nearest([0.5, 1], [0, 0], [1, 0])).toEqual([0.5, 0]);
    expect(nearest([2, 1], [0, 0], [1, 0])).toEqual([1, 0]);
    const hit = edgeAt(polygon(SQUARE), [0.0151, -0.0151], 0.001);
    expect(hit?.edge).toBe(3);
    expect(hit?.place[0]).toBeCloseTo(0.015, 6);
  });
});

describe('figures', () => {
  it('to start from have enough points', () => {
    for (const { shape: which } of SHAPES.slice(1)) {
      expect(shape(which).points.length, which).toBeGreaterThan(1);
    }
  });
});
