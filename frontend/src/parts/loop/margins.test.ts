import { expect, it, vi } from 'vitest';
import type { Loops } from '../../app/api/types';
import { LoopMargins, type LoopAt, type LoopFigures } from './loops.svelte';
import { inDecibels, instability, marginCells } from './margins';

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
  standstill: { ...SLIDING, velocity: 0 },
  worst: {
    stable: true,
    velocity: 0,
    gain_margin: { value: 1.2, velocity: 0 },
    phase_margin: { value: Math.PI / 6, velocity: 0.0436 },
    Ms: { value: 2.2, velocity: 0.17 },
  },
};
const LIMITS = { gain_margin: 1.1, phase_margin: Math.PI / 5, Ms: null };
const cells = (worst: Partial<LoopFigures['worst']> = {}) =>
  marginCells({ ...LOOP, worst: { ...LOOP.worst, ...worst } }, (name) => LIMITS[name]);

it('writes margins in decibels', () => {
  expect(inDecibels(2)).toBe('6.02');
  expect(inDecibels(null)).toBe('∞');
});

it('shows the worst at any velocity, and where it is', () => {
  expect(cells().map(({ text, place }) => [text, place])).toEqual([
    ['1.58', 'at standstill'],
    ['30.0', 'sliding at 43.6 mm/s'],
    ['2.20', 'sliding at 170 mm/s'],
  ]);
  expect(cells({ gain_margin: null })[0]?.text).toBe('∞');
});

it('says where a loop is unstable, between the two velocities too', () => {
  expect(instability(LOOP)).toBe('');
  const worst = { ...LOOP.worst, stable: false, velocity: 0.0436 };
  expect(instability({ ...LOOP, worst })).toBe('sliding at 43.6 mm/s');
  const standstill = { ...LOOP.standstill, stable: false };
  expect(instability({ ...LOOP, standstill, worst: { ...worst, velocity: 0 } })).toBe(
    'at standstill',
  );
  expect(instability({ ...LOOP, stable: false, standstill, worst })).toBe(
    'sliding and at standstill',
  );
});

it('marks a margin that is beyond its limit, and nothing without one', () => {
  expect(cells().map(({ term, text, holds }) => [term, text, holds])).toEqual([
    ['GM', '1.58', true],
    ['PM', '30.0', false],
    ['M_s', '2.20', true],
  ]);
  expect(cells()[2]?.limitText).toBe('');
  expect(cells()[1]?.limitText).toBe('at least 36.0°');
});

it('asks one question at a time, and after a while the newest', async () => {
  vi.useFakeTimers();
  const requests: unknown[] = [];
  const answers: ((loops: Loops) => void)[] = [];
  const margins = new LoopMargins({
    loop: (body: unknown) => {
      requests.push(body);
      return new Promise((resolve) => answers.push(resolve));
    },
  } as never);
  const question = (k_p: number) => ({ scenario: {} as never, set: { k_p } });
  for (const k_p of [1, 2, 3]) margins.ask(question(k_p));
  expect(requests).toEqual([question(1)]);
  answers[0]?.({ variants: {} });
  await vi.advanceTimersByTimeAsync(20);
  expect(requests).toHaveLength(1);
  await vi.advanceTimersByTimeAsync(20);
  expect(requests).toEqual([question(1), question(3)]);
  expect(margins.asking).toBe(true);
  answers[1]?.({ variants: { A: { axes: { x: LOOP }, note: null } } });
  await vi.advanceTimersByTimeAsync(1);
  expect(margins.asking).toBe(false);
  expect(margins.of('A', 'x')?.worst).toBe(LOOP.worst);
  vi.useRealTimers();
});

it('shows what the page computes while a control moves, and asks the server at rest', async () => {
  vi.useFakeTimers();
  const answers: ((loops: Loops) => void)[] = [];
  const loop = vi.fn(() => new Promise<Loops>((resolve) => answers.push(resolve)));
  const margins = new LoopMargins({ loop } as never);
  const question = (k_p: number) => ({ scenario: {} as never, set: { k_p } });
  const loops = (note: string) => ({ A: { axes: {}, note } });
  margins.take(loops('page 0'));
  for (const k_p of [1, 2, 3]) {
    margins.ask(question(k_p));
    margins.take(loops(`page ${k_p}`));
    await vi.advanceTimersByTimeAsync(100);
    expect(margins.reason('A')).toBe(`page ${k_p}`);
  }
  expect(loop).not.toHaveBeenCalled();
  await vi.advanceTimersByTimeAsync(100);
  expect(loop.mock.calls).toEqual([[question(3)]]);
  margins.ask(question(4));
  margins.take(loops('page 4'));
  answers[0]?.({ variants: loops('server 3') });
  await vi.advanceTimersByTimeAsync(100);
  expect(margins.reason('A')).toBe('page 4');
  await vi.advanceTimersByTimeAsync(200);
  answers[1]?.({ variants: loops('server 4') });
  await vi.advanceTimersByTimeAsync(1);
  expect([margins.reason('A'), margins.asking]).toEqual(['server 4', false]);
  vi.useRealTimers();
});

it('marks margins that are older than the controls, until the newest come', async () => {
  vi.useFakeTimers();
  const answers: ((loops: Loops) => void)[] = [];
  const margins = new LoopMargins({
    loop: () => new Promise<Loops>((resolve) => answers.push(resolve)),
  } as never);
  const question = (k_p: number) => ({ scenario: {} as never, set: { k_p } });
  const answer = async (k: number) => {
    answers[k]?.({ variants: { A: { axes: { x: LOOP }, note: null } } });
    await vi.advanceTimersByTimeAsync(40);
  };
  const late = async (time: number) => {
    await vi.advanceTimersByTimeAsync(time);
    return margins.late;
  };
  margins.ask(question(1));
  expect(await late(2000)).toBe(false); // nothing is shown
  await answer(0);
  margins.ask(question(2));
  expect(await late(400)).toBe(false);
  margins.ask(question(3));
  expect(await late(200)).toBe(true);
  await answer(1);
  expect(margins.late).toBe(false); // they follow the control
  expect(await late(600)).toBe(true);
  await answer(2);
  expect(await late(2000)).toBe(false);
  margins.ask(question(4));
  margins.take({ A: { axes: { x: LOOP }, note: null } });
  expect(await late(2000)).toBe(false); // the page has them
  vi.useRealTimers();
});
