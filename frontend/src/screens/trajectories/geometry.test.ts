import { describe, expect, it } from 'vitest';
import { newPath, type Point } from './drawn-path';
import { edgeAt, nearest, outline, pointAt } from './geometry';
import { converted, ring, shape, SHAPES } from './shapes';

describe('outline', () => {
  it('of a polyline is its corners, closed ones with the first again', () => {
    const points = ring(4, 0.03, 0);
    expect(outline(newPath(points, false)).curve).toEqual(points);
    expect(outline(newPath(points, true)).curve).toEqual([...points, points[0]]);
  });

  it('of a smooth closed path through a circle is nearly one', () => {
    const path = { ...newPath(ring(12, 0.03, 0), true), geometry: 'spline' as const };
    const { curve, edge } = outline(path);
    expect(edge.at(-1)).toBe(11);
    for (const [x, y] of curve) expect(Math.hypot(x, y)).toBeCloseTo(0.03, 4);
  });

  it('of a smooth path goes through its points', () => {
    const points: Point[] = [
      [0, 0],
      [0.01, 0.03],
      [0.05, -0.02],
      [0.02, 0.01],
    ];
    for (const closed of [false, true]) {
      const { curve } = outline({ ...newPath(points, closed), geometry: 'spline' });
      points.forEach((point, i) => {
        expect(curve[16 * i]?.[0]).toBeCloseTo(point[0], 12);
        expect(curve[16 * i]?.[1]).toBeCloseTo(point[1], 12);
      });
    }
  });
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
    const found = edgeAt(newPath(ring(4, 0.03, 0), true), [0.0151, -0.0151], 0.001);
    expect(found?.edge).toBe(3);
    expect(found?.place[0]).toBeCloseTo(0.015, 6);
  });
});

describe('figures', () => {
  it('to start from have enough points', () => {
    for (const { shape: which } of SHAPES.slice(1)) {
      expect(shape(which).points.length, which).toBeGreaterThan(1);
    }
  });

  it('become points at the same corners and in the same time', () => {
    const table = {
      kind: 'polygon',
      vertices: [
        [0.03, 0],
        [0, 0.03],
        [-0.03, 0],
      ],
      frequency: 0.5,
      laps: 2,
    };
    const path = converted(table);
    expect(path?.points).toEqual(table.vertices);
    expect(path?.lap_time).toBe(2);
    expect(path?.laps).toBe(2);
  });

  it('become points where they turn about a centre, and none for a sine', () => {
    const circle = {
      kind: 'circle',
      radius: 0.01,
      center: { x: 0.02, y: 0 },
      frequency: 1,
      laps: 3,
    };
    expect(converted(circle)?.points[0]).toEqual([0.03, 0]);
    expect(converted({ kind: 'sine' })).toBeNull();
  });

  it('of a star join its points as it is drawn', () => {
    const star = { kind: 'star', circumradius: 0.03, points: 5, density: 2, frequency: 1, laps: 1 };
    const [a, b] = converted(star)?.points ?? [];
    const chord = Math.hypot((a?.[0] ?? 0) - (b?.[0] ?? 0), (a?.[1] ?? 0) - (b?.[1] ?? 0));
    expect(chord).toBeCloseTo(0.05706, 5);
  });
});
