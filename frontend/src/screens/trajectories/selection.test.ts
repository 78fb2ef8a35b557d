import { describe, expect, it } from 'vitest';
import { newPath, withoutPoints, type Point } from './drawn-path';
import { drawn, simplified } from './shapes';
import { aligned, boundsOf, distributed, movedBy, rotated, scaled, within } from './selection';

const PATH = newPath(
  [
    [0, 0],
    [0.01, 0],
    [0.03, 0.02],
    [0.05, 0.05],
  ],
  false,
);
const THREE = new Set([3, 1, 0]);

const near = (points: readonly Point[]) =>
  points.map(([x, y]) => [Number(x.toFixed(6)) + 0, Number(y.toFixed(6)) + 0]);

describe('several points', () => {
  it('are found in a box, whichever corners are given', () => {
    expect(within(PATH, [0.04, 0.03], [-0.01, 0])).toEqual([0, 1, 2]);
    expect(boundsOf(PATH, THREE)).toEqual({ west: 0, east: 0.05, south: 0, north: 0.05 });
  });

  it('are moved, scaled, mirrored and turned about the middle of their box', () => {
    expect(near(movedBy(PATH, THREE, [0.01, 0]).points)[2]).toEqual([0.03, 0.02]);
    expect(near(scaled(PATH, THREE, [2, 1]).points)).toEqual([
      [-0.025, 0],
      [-0.005, 0],
      [0.03, 0.02],
      [0.075, 0.05],
    ]);
    expect(near(scaled(PATH, THREE, [-1, 1]).points)[0]).toEqual([0.05, 0]);
    expect(near(rotated(PATH, THREE, Math.PI / 2).points)).toEqual([
      [0.05, 0],
      [0.05, 0.01],
      [0.03, 0.02],
      [0, 0.05],
    ]);
  });

  it('are brought onto a line and spread along it in their order', () => {
    expect(near(aligned(PATH, THREE, 'north').points).map(([, y]) => y)).toEqual([
      0.05, 0.05, 0.02, 0.05,
    ]);
    expect(near(aligned(PATH, THREE, 'middle').points).map(([x]) => x)).toEqual([
      0.025, 0.025, 0.03, 0.025,
    ]);
    expect(near(distributed(PATH, THREE, 0).points).map(([x]) => x)).toEqual([
      0, 0.025, 0.03, 0.05,
    ]);
  });

  it('are removed, and corners stay at their points', () => {
    const path = { ...PATH, geometry: 'spline' as const, corners: [1, 2] };
    const left = withoutPoints(path, new Set([0, 1]));
    expect(left.points).toEqual(PATH.points.slice(2));
    expect(left.corners).toEqual([0]);
  });
});

describe('a stroke of the hand', () => {
  const wave = Array.from({ length: 201 }, (_, i): Point => [i * 1e-4, 2e-3 * Math.sin(i / 20)]);

  it('keeps its ends and no more points than it needs', () => {
    const points = simplified(wave, 1e-4);
    expect(points[0]).toBe(wave[0]);
    expect(points.at(-1)).toBe(wave.at(-1));
    expect(points.length).toBeGreaterThan(6);
    expect(points.length).toBeLessThan(40);
  });

  it('is closed where it comes back to its start', () => {
    const ring = Array.from({ length: 100 }, (_, i): Point => {
      return [0.02 * Math.cos(i / 16), 0.02 * Math.sin(i / 16)];
    });
    expect(drawn(ring, 1e-4, 3e-3).closed).toBe(true);
    expect(drawn(ring, 1e-4, 1e-4).closed).toBe(false);
    expect(drawn([[0, 0]], 1e-4, 1e-3).points).toHaveLength(1);
  });
});
