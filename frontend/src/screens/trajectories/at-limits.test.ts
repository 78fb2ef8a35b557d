import { expect, test } from 'vitest';
import { atLimits } from './at-limits';

test('variants at a limit are named with the share of the time, others are not', () => {
  const free = { saturated_fraction: 0 };
  const variants = {
    A: { diverged: { time: 0.4 }, axes: { x: free, y: { saturated_fraction: null } } },
    B: { diverged: null, axes: { x: free, y: { saturated_fraction: 0.452 } } },
    C: { diverged: null, axes: { y: free } },
  };
  expect(atLimits(variants)).toEqual([
    'A diverges on this path.',
    'B has its command or currents at a limit 45 % of the time on y.',
  ]);
});
