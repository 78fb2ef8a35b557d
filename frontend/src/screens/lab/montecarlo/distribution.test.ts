import { expect, it } from 'vitest';
import type { MonteCarlo } from '../../../app/api/types';
import { axesShown, histogramSeries, influences, metricsShown } from './distribution';

const peak = 'max_abs_following_error';
const variant = (rho: (number | null)[]) => ({ axes: { x: { correlations: { [peak]: rho } } } });
const study = {
  significant: 0.2,
  histograms: {
    x: {
      [peak]: { edges: [1, 2, 3], log: false, counts: { A: [4, 0], B: [1, 3] } },
      itae: null,
    },
  },
  parameters: {
    x: [
      { path: 'friction.F_s', of: 'value' },
      { path: 'friction.F_s', of: 'deviation' },
      { path: 'amplifiers.offset.2', of: 'value' },
      { path: 'amplifiers.offset.2', of: 'deviation' },
      { path: 'friction.v_s', of: 'value' },
    ],
  },
  variants: {
    A: variant([0.84, 0.1, -0.1, 0.05, null]),
    B: variant([-0.25, 0.48, 0.05, -0.02, null]),
  },
} as unknown as MonteCarlo;

it('draws the bins as steps that end at the last edge', () => {
  const [a, b] = histogramSeries(study, 'x', peak);
  expect(a).toMatchObject({ name: 'A', ink: 'a', kind: 'step', x: [1, 2, 3], y: [4, 0, null] });
  expect(b).toMatchObject({ name: 'B', y: [1, 3, null] });
  expect(a?.area).not.toBe(b?.area);
  expect(histogramSeries(study, 'x', 'itae')).toEqual([]);
  expect(axesShown(study)).toEqual(['x']);
  expect(metricsShown(study, 'x').map(({ key }) => key)).toEqual([peak]);
});

it('sorts parameters by the strongest variant, and leaves out the weaker reading of one', () => {
  const rows = influences(study, 'x', peak);
  expect(rows.map(({ key }) => key)).toEqual([
    'value friction.F_s',
    'deviation friction.F_s',
    'value amplifiers.offset.2',
  ]);
  expect(rows.map(({ beyond }) => beyond)).toEqual([true, true, false]);
  expect(rows[1]?.name).toMatch(/^deviation of /);
  expect(rows[2]?.name).toMatch(/, phase c$/);
  expect(rows[0]?.rho).toEqual([0.84, -0.25]);
});
