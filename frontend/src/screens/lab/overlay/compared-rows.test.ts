import { expect, it } from 'vitest';
import type { Metrics } from '../../../app/api/types';
import { comparedRows, sameWindow } from './compared-rows';

const metrics = (error: number, window = { start: 4.5, end: 10.5 }): Metrics => ({
  window,
  variants: {
    B: {
      diverged: null,
      axes: { x: { max_abs_following_error: error } },
      contour: { max: 2 * error, rms: error },
    },
  },
});

it('shows each run with the present value, in one unit, and how much that differs', () => {
  const [first] = comparedRows(metrics(1.5e-6), [metrics(2e-6), metrics(0.5e-6)], 'B');
  expect(first).toMatchObject({ name: 'max |e_x|', unit: 'µm', now: '1.50' });
  expect(first?.then).toEqual([
    { value: '2.00', change: '−25.0 %' },
    { value: '0.500', change: '+200 %' },
  ]);
});

it('a run without the metric has a dash', () => {
  const empty = { ...metrics(1), variants: {} };
  const [first] = comparedRows(metrics(1.5e-6), [empty], 'B');
  expect(first?.then).toEqual([{ value: '–', change: '–' }]);
});

it('windows are alike as they are shown', () => {
  const window = { start: 4.5, end: 10.5 };
  expect(sameWindow(window, { start: 4.501, end: 10.5 })).toBe(true);
  expect(sameWindow(window, { start: 3, end: 9 })).toBe(false);
});
