import { describe, expect, it } from 'vitest';
import type { Loops } from '../api/types';
import { LoopMargins, type LoopAt, type LoopFigures } from './loops.svelte';
import { inDecibels, instability, leastGainMargin, marginCells } from './margins';

const SLIDING: LoopAt = {
  velocity: 0.17,
  stable: true,
  k_p_limit: 3.3e6,
  k_d_limit: null,
  crossover: 46,
  phase_margin: Math.PI / 6,
  gain_margin: 10,
  gain_reduction: null,
  Ms: 2.2,
  bandwidth: 73,
};
const LOOP: LoopFigures = {
  ...SLIDING,
  standstill: { ...SLIDING, velocity: 0, phase_margin: 2, gain_margin: 20, Ms: 1.5 },
};
const LIMITS = { gain_margin: 2, phase_margin: Math.PI / 5, Ms: null };
const cells = (loop: Partial<LoopFigures> = {}) =>
  marginCells({ ...LOOP, ...loop }, (name) => LIMITS[name]);

it('writes margins in decibels', () => {
  expect(inDecibels(2)).toBe('6.02');
  expect(inDecibels(null)).toBe('∞');
});

it('shows the worse of sliding and standstill, and where it is', () => {
  const stuck = { ...LOOP.standstill, gain_margin: 1.2 };
  expect(cells({ standstill: stuck }).map(({ text, place }) => [text, place])).toEqual([
    ['1.58', 'at standstill'],
    ['30.0', 'sliding at 170 mm/s'],
    ['2.20', 'sliding at 170 mm/s'],
  ]);
  expect(instability(LOOP)).toBe('');
  const nowhere = { ...stuck, stable: false };
  expect(instability({ ...LOOP, standstill: nowhere })).toBe('at standstill');
  // With a velocity it would be too long for its line.
  expect(instability({ ...LOOP, stable: false, standstill: nowhere })).toBe(
    'sliding and at standstill',
  );
});

describe('margins against their limits', () => {
  it('marks what is beyond a limit, and nothing without one', () => {
    expect(cells().map(({ term, text, holds }) => [term, text, holds])).toEqual([
      ['GM', '20.0', true],
      ['PM', '30.0', false],
      ['M_s', '2.20', true],
    ]);
    expect(cells()[2]?.limitText).toBe('');
    expect(cells()[1]?.limitText).toBe('at least 36.0°');
  });

  it('counts the smaller factor of a gain that may grow or fall', () => {
    expect(leastGainMargin({ ...LOOP, gain_reduction: 0.5 })).toBe(2);
    expect(leastGainMargin({ ...LOOP, gain_margin: null })).toBeNull();
    expect(cells({ gain_reduction: 0.6 })[0]?.holds).toBe(false);
  });
});

it('asks one question at a time, and after it the newest', async () => {
  const asked: unknown[] = [];
  const answers: ((loops: Loops) => void)[] = [];
  const margins = new LoopMargins({
    loop: (body: unknown) => {
      asked.push(body);
      return new Promise((resolve) => answers.push(resolve));
    },
  } as never);
  const question = (k_p: number) => ({ scenario: {} as never, set: { k_p } });
  for (const k_p of [1, 2, 3]) margins.ask(question(k_p));
  expect(asked).toEqual([question(1)]);
  answers[0]?.({ variants: {} });
  await new Promise((resolve) => setTimeout(resolve));
  expect(asked).toEqual([question(1), question(3)]);
  expect(margins.asking).toBe(true);
  answers[1]?.({ variants: { A: { axes: { x: LOOP }, note: null } } });
  await new Promise((resolve) => setTimeout(resolve));
  expect(margins.asking).toBe(false);
  expect(margins.of('A', 'x')?.Ms).toBe(2.2);
});
