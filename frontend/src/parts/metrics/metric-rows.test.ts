import { describe, expect, it } from 'vitest';
import type { Metrics } from '../../app/api/types';
import { changesWithin, rows } from './metric-rows';

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
    });
    expect(first?.change).toBeCloseTo(-0.8746, 4);
  });
  it('shares one unit down a column, so that errors compare', () => {
    const small = { max_abs_following_error: 0.251e-6, rms_following_error: 0.0449e-6 };
    const large = { max_abs_following_error: 20.5e-6, rms_following_error: 881e-9 };
    const both = {
      ...metrics,
      variants: {
        A: { diverged: null, axes: { x: large }, contour: { max: 18e-6, rms: 10e-6 } },
        B: { diverged: null, axes: { x: small }, contour: { max: 0.2e-6, rms: 50e-9 } },
      },
    };
    const cells = rows(both, ['A', 'B']).map(({ unit, values }) => [...values, unit]);
    expect(cells).toEqual([
      ['20.5', '0.251', 'µm'],
      ['0.881', '0.045', 'µm'],
      ['18.0', '0.200', 'µm'],
      ['10.0', '0.050', 'µm'],
    ]);
  });
  it('leaves out metrics without a value', () => {
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

describe('changes within the window', () => {
  const window = { start: 4.5, end: 10.5 };
  it.each([
    [[], ''],
    [[2, 4.5, 10.5, 12], ''],
    [[12.3, 7.1234], 'Includes a change at 7.12 s.'],
    [[9, 5, 5], 'Includes changes at 5 and 9 s.'],
    [[5, 6, 7], 'Includes changes at 5, 6 and 7 s.'],
    [[5, 6, 7, 8, 20], 'Includes 4 changes, the last at 8 s.'],
  ])('of %s are counted', (times, text) => {
    expect(changesWithin(window, times)).toBe(text);
  });
});
