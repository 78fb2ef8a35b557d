import { describe, expect, it } from 'vitest';
import {
  inserted,
  moved,
  newPath,
  outside,
  removed,
  repeated,
  shifted,
  snap,
  timedBy,
  withClosed,
  withLaw,
  type Point,
} from './drawn-path';

const SQUARE: Point[] = [
  [0, 0],
  [0.01, 0],
  [0.01, 0.01],
];

describe('points', () => {
  it('snap to the grid, and without one to a nanometre', () => {
    expect(snap(0.01234, 1e-3)).toBe(0.012);
    expect(snap(0.01234, 5e-3)).toBe(0.01);
    expect(snap(0.0123456789123, 0)).toBe(0.012345679);
    expect(snap(7, 1e-3)).toBe(1);
  });

  it('are moved, added and removed without touching the path they come from', () => {
    const path = newPath(SQUARE, true);
    expect(moved(path, 1, [0.02, 0.03]).points[1]).toEqual([0.02, 0.03]);
    expect(inserted(path, 1, [0.005, 0]).points).toHaveLength(4);
    expect(inserted(path, 3, [0, 0.01]).points[3]).toEqual([0, 0.01]);
    expect(shifted(path, [0.001, -0.001]).points[0]).toEqual([0.001, -0.001]);
    expect(path.points).toEqual(SQUARE);
  });

  it('of a closed path become an open one when too few are left', () => {
    const path = { ...newPath(SQUARE, true), laps: 3 };
    const left = removed(path, 0);
    expect(left.closed).toBe(false);
    expect(left.laps).toBe(1);
    expect(withClosed(path, false).laps).toBe(1);
  });

  it('that repeat are found, round the end of a closed path too', () => {
    expect(repeated(newPath(SQUARE, true))).toBeNull();
    const again: Point[] = [...SQUARE, [0, 0]];
    expect(repeated(newPath(again, false))).toBeNull();
    expect(repeated(newPath(again, true))).toBe(3);
  });

  it('outside the stroke are listed, those on its edge are not', () => {
    const points: Point[] = [
      [0.085, -0.145],
      [0.0851, 0],
      [0, 0.2],
    ];
    expect(outside(points, [0.085, 0.145])).toEqual([1, 2]);
  });
});

describe('motion profiles', () => {
  it('have what they need and nothing else', () => {
    const path = newPath(SQUARE, true);
    const limited = withLaw(path, 'jerk_limited');
    expect(limited.j_max).toBeGreaterThan(0);
    expect(withLaw(limited, 'trapezoid').j_max).toBeNull();
    const timed = timedBy(limited, 'time', 3);
    expect([timed.v_max, timed.a_max, timed.j_max, timed.lap_time]).toEqual([null, null, null, 3]);
    expect(withLaw(timed, 'jerk_limited').j_max).toBeNull();
    const back = timedBy(timed, 'limits', 0);
    expect(back.lap_time).toBeNull();
    expect(back.j_max).toBeGreaterThan(0);
  });
});
