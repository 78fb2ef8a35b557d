import { describe, expect, it } from 'vitest';
import type { MonteCarlo } from '../../../app/api/types';
import { covers, meeting, quantileBands, shareText, spreadRows } from './spread';

const quantiles = (q50: number) => ({
  min: q50 / 2,
  q05: q50 / 1.5,
  q50,
  q95: q50 * 1.5,
  max: q50 * 2,
  cases: 4,
});
const row = [0, 1e-6];
const band = { min: row, q05: row, q25: row, q50: row, q75: row, q95: row, max: row };

function axis(peaks: (number | null)[], middle: number) {
  const metrics = {
    max_abs_following_error: quantiles(middle),
    rms_following_error: quantiles(middle / 2),
  };
  return { metrics, band, peaks };
}

const study = {
  cases: 4,
  time: [4.5, 10.49],
  variants: {
    A: {
      axes: { x: axis([1e-5, 2e-5, 3e-5, null], 2e-5), y: axis([1e-5, 1e-5, 9e-5, 1e-5], 1e-5) },
    },
    B: { axes: { x: axis([1e-6, 2e-6, 3e-6, 4e-6], 2e-6), y: { ...axis([], 1e-6), band: null } } },
  },
  improvement: { x: { max_abs_following_error: quantiles(0.5) }, y: {} },
} as unknown as MonteCarlo;

describe('a spec', () => {
  it('is met by the plants that stay within it on every axis it names', () => {
    expect(meeting(study, 'A', { x: 2e-5 })?.share).toBe(0.5);
    expect(meeting(study, 'A', { x: 5e-5, y: 5e-5 })?.share).toBe(0.5);
    expect(meeting(study, 'A', { y: 1e-5 })?.share).toBe(0.75);
  });

  it('is not met by a plant on which the variant diverged', () => {
    expect(meeting(study, 'A', { x: 1 })?.share).toBe(0.75);
  });

  it('says nothing without a number', () => {
    expect(meeting(study, 'A', {})).toBeNull();
    expect(meeting(study, 'C', { x: 1 })).toBeNull();
  });

  it('comes with an interval that four plants leave wide', () => {
    const all = meeting(study, 'B', { x: 1 });
    expect(all).toMatchObject({ share: 1, high: 1 });
    expect(all?.low).toBeCloseTo(0.51, 2);
  });
});

it('bands are those of variants that have one', () => {
  expect(quantileBands(study, 'x').map(({ ink }) => ink)).toEqual(['a', 'b']);
  expect(quantileBands(study, 'y').map(({ ink }) => ink)).toEqual(['a']);
});

it('rows have a unit of their own', () => {
  const rows = spreadRows(study);
  expect(rows[0]).toEqual({ name: 'A max |e_x|', unit: 'µm', values: ['13.3', '20.0', '30.0'] });
  expect(rows.find(({ name }) => name === 'less max |e_x| in B')?.values[1]).toBe('50');
});

it('gives both variants of a metric one unit', () => {
  const y = { ...study.variants['A']?.axes.x, ...axis([], 2e-7) };
  const mixed = { ...study, variants: { ...study.variants, B: { axes: { x: y } } } };
  const [a, b] = spreadRows(mixed as unknown as MonteCarlo);
  expect(b).toMatchObject({ name: 'B max |e_x|', unit: 'µm' });
  expect(a?.unit).toBe(b?.unit);
});

it('shares are not rounded to certainty', () => {
  expect([0, 0.0004, 0.717, 0.9997, 1].map(shareText)).toEqual([
    '0 %',
    '< 0.1 %',
    '71.7 %',
    '> 99.9 %',
    '100 %',
  ]);
});

it('bands of another stretch of time are not drawn', () => {
  expect(covers(study.time, 4.5, 10.5)).toBe(true);
  expect(covers(study.time, 0, 3)).toBe(false);
  expect(covers([], 0, 3)).toBe(false);
});
