import { describe, expect, it } from 'vitest';
import type { Metrics } from '../api/types';
import { rows } from './metrics';

const metrics: Metrics = {
  window: { start: 4.5, end: 10.5 },
  variants: {
    A: {
      diverged: null,
      axes: { x: { max_abs_following_error: 20.5e-6, max_current: 3.1, settling_time: null } },
      contour: { max: 18e-6, rms: 10e-6 },
    },
    B: {
      diverged: null,
      axes: { x: { max_abs_following_error: 2.57e-6, max_current: 3.2, settling_time: null } },
      contour: { max: 2e-6, rms: 1e-6 },
    },
  },
};

describe('rows', () => {
  it('shares one unit on a line and compares B with A', () => {
    const [first] = rows(metrics, ['A', 'B']);
    expect(first).toMatchObject({
      name: 'max |e_x|',
      unit: 'µm',
      values: ['20.5', '2.57'],
      better: true,
    });
    expect(first?.change).toBeCloseTo(-0.8746, 4);
  });
  it('judges errors, not currents', () => {
    const current = rows(metrics, ['A', 'B']).find((row) => row.name === 'peak i_x');
    expect(current?.better).toBeNull();
    expect(current?.change).toBeGreaterThan(0);
  });
  it('leaves out what nobody has', () => {
    const names = rows(metrics, ['A', 'B']).map((row) => row.name);
    expect(names).toEqual(['max |e_x|', 'contour max', 'contour RMS', 'peak i_x']);
  });
  it('shows one variant alone, and none that diverged', () => {
    expect(rows(metrics, ['A'])[0]).toMatchObject({ values: ['20.5'], change: null });
    const diverged = { ...metrics.variants.B, diverged: { time: 1, channel: 'x' }, axes: {} };
    const both = { ...metrics, variants: { ...metrics.variants, B: diverged } } as Metrics;
    expect(rows(both, ['A', 'B'])[0]?.values).toEqual(['20.5', '–']);
  });
});
