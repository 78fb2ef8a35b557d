import { expect, it } from 'vitest';
import type { Candidate, TuneGroup } from '../api/types';
import { bestSoFar, inDecibels, linesOf, pickedLine } from './candidates';

function candidate(origin: Candidate['origin'], start: number | null, peaks: (number | null)[]) {
  const metrics = Object.fromEntries(
    peaks.map((peak, i) => [
      `motor ${i.toString()}`,
      { peak, rms: peak, itae: 1, settling: 1, effort: 3, force: 5, saturated: 0 },
    ]),
  );
  const tuned = { k_p: 2e5, k_d: 1500, metrics, margins: null };
  return {
    origin,
    start,
    axes: { x: tuned },
    also: {},
    cost: 1,
    feasible: true,
    violations: [],
    set: {},
  };
}

const GROUP: TuneGroup = {
  axes: ['x'],
  present: candidate('present', null, [3e-6]),
  paper: candidate('paper', null, [2e-6]),
  candidates: [candidate('start', 2, [1e-6, 4e-6]), candidate('start', 0, [1e-6, null])],
  starts: [],
};

it('lists the present gains, the paper’s and the candidates in their order', () => {
  expect(linesOf([GROUP], 'x').map(({ id }) => id)).toEqual([
    'present',
    'paper',
    'start 2',
    'start 0',
  ]);
  expect(linesOf([GROUP], 'y')).toEqual([]);
});

it('tells the error on the worst motor, and none where one ran away', () => {
  const [, , worst, away] = linesOf([GROUP], 'x');
  expect(worst?.peak).toBe(4e-6);
  expect(away?.peak).toBeNull();
});

it('makes a line of gains that were picked, with what choosing them sets', () => {
  const { set, cost } = pickedLine({ k_p: 3e5, k_d: 900, cost: 2 }, 'B', 'y');
  expect(cost).toBe(2);
  expect(set).toEqual({
    'variants.B.controller.y.k_p': 3e5,
    'variants.B.controller.y.k_d': 900,
  });
});

it('keeps the best so far, and nothing before a constraint is held', () => {
  expect(bestSoFar([null, 3, 5, null, 2])).toEqual([null, 3, 3, 3, 2]);
});

it('writes margins in decibels', () => {
  expect(inDecibels(2)).toBe('6.02');
  expect(inDecibels(null)).toBe('∞');
});
