import { expect, it } from 'vitest';
import type { Candidate, GainMargins, TuneGroup } from '../../app/api/types';
import { bestSoFar, choiceText, linesOf, pickedLine, placesOf } from './candidates';

const at = (value: number, velocity: number) => ({ value, velocity });
const MARGINS: Record<string, GainMargins> = {
  'motor 0': {
    stable: true,
    gain_margin: at(2.64, 0.1),
    phase_margin: at(0.58, 0.1),
    Ms: at(2, 0.1),
  },
  'motor 1': { stable: true, gain_margin: at(2.22, 0.03), phase_margin: null, Ms: at(1.9, 0.1) },
};

function candidate(origin: Candidate['origin'], start: number | null, peaks: (number | null)[]) {
  const metrics = Object.fromEntries(
    peaks.map((peak, i) => [
      `motor ${i.toString()}`,
      { peak, rms: peak, itae: 1, settling: 1, effort: 3, force: 5, saturated: 0 },
    ]),
  );
  const tuned = { k_p: 2e5, k_d: 1500, metrics, margins: MARGINS };
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

it('tells the error on the worst motor, and none where one diverged', () => {
  const [, , worst, away] = linesOf([GROUP], 'x');
  expect(worst?.peak).toEqual({ value: 4e-6, motor: 'motor 1', velocity: null });
  expect(away?.peak).toEqual({ value: null, motor: 'motor 1', velocity: null });
});

it('tells each margin on the motor where it is least', () => {
  const line = linesOf([GROUP], 'x')[2];
  expect(line?.stable).toBe(true);
  expect(line?.gainMargin).toEqual({ value: 2.22, motor: 'motor 1', velocity: 0.03 });
  expect(line?.phaseMargin).toEqual({ value: 0.58, motor: 'motor 0', velocity: 0.1 });
  expect(line && placesOf(line)).toBe(
    'peak motor 1, rms motor 1, GM motor 1 at 30.0 mm/s, PM motor 0 at 100 mm/s',
  );
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

it('names the chosen line of each axis', () => {
  const chosen = [
    { axis: 'x', id: 'start 2' },
    { axis: 'y', id: 'paper' },
  ] as const;
  expect(choiceText(chosen)).toBe('x 2, y paper');
});
