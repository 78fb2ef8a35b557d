import { expect, it } from 'vitest';
import { checksOf, lasting, obstacle, stepObstacle, type Situation } from './arm-checks';
import { exampleStatus } from './example-status';

const situation = (change: Partial<Situation> = {}): Situation => ({
  status: exampleStatus({ holder: 'browser 1' }),
  held: true,
  gains: 'A of circle',
  silent: '',
  ...change,
});
const withSto = (sto: boolean | null) => {
  const status = exampleStatus();
  return { ...status, drives: status.drives.map((drive) => ({ ...drive, sto })) };
};

it('finds no obstacle when everything holds', () => {
  expect(obstacle(situation())).toBe('');
  expect(checksOf(situation()).map(({ holds }) => holds)).toEqual([true, true, true, true, true]);
});

it.each([
  [{ silent: 'gone' }, 'does not answer'],
  [{ status: exampleStatus({ state: 'offline' }) }, 'no link'],
  [{ status: exampleStatus({ state: 'fault' }) }, 'Reset it first'],
  [{ status: withSto(true) }, 'STO is active'],
  [{ status: exampleStatus({}, { phase_locked: false }) }, 'in phase'],
  [{ held: false }, 'Take control'],
  [{ gains: '' }, 'no session'],
] as const)('refuses to arm: %o', (change, reason) => {
  expect(obstacle(situation(change as Partial<Situation>))).toContain(reason);
  expect(
    checksOf(situation(change as Partial<Situation>)).some(({ holds }) => holds === false),
  ).toBe(true);
});

it('waits for the phase, which comes back by itself', () => {
  const status = exampleStatus({}, { phase_locked: false });
  expect(lasting(situation({ status }))).toBe('');
  expect(lasting(situation({ held: false }))).toBe('Take control first.');
});

it('says where STO is not reported, and does not take that for a permission', () => {
  const sto = checksOf(situation({ status: withSto(null) })).find(({ name }) => name === 'STO');
  expect(sto).toMatchObject({ holds: null, text: 'not reported by the drives' });
  expect(obstacle(situation({ status: withSto(null) }))).toBe('');
});

it('names who holds control', () => {
  const status = exampleStatus({ holder: 'script' });
  const control = checksOf(situation({ held: false, status })).find(
    ({ name }) => name === 'control',
  );
  expect(control).toMatchObject({ holds: false, text: 'held by script' });
});

it.each([
  [{ silent: 'gone' }, 'does not answer'],
  [{ status: exampleStatus({ state: 'offline' }) }, 'no link'],
  [{ status: exampleStatus({ state: 'fault' }) }, 'Reset it first'],
  [{ status: exampleStatus({ state: 'holding' }) }, 'Disarm first'],
  [{ status: exampleStatus({ state: 'stopping' }) }, 'come to rest'],
  [{ held: false }, 'Take control'],
] as const)('says what keeps a step from beginning: %o', (change, reason) => {
  expect(stepObstacle(situation(change as Partial<Situation>), false)).toContain(reason);
});

it('asks for the phase and for STO only where a step has torque', () => {
  for (const status of [exampleStatus({}, { phase_locked: false }), withSto(true)]) {
    expect(stepObstacle(situation({ status }), false)).toBe('');
    expect(stepObstacle(situation({ status }), true)).not.toBe('');
  }
});

it('is not armed with the commissioning of other drives', () => {
  const other = situation({
    status: exampleStatus({ other_drives: '1 commissioned, 2 found' }),
    commissioned: { done: 0, of: 8 },
  });
  expect(obstacle(other)).toContain('Other drives were commissioned');
  expect(checksOf(other).find(({ name }) => name === 'commissioning')).toEqual({
    name: 'commissioning',
    holds: false,
    text: 'of other drives',
  });
  expect(stepObstacle(other, false)).toBe(''); // the first step begins anew
});

it('says in the question how much of commissioning is done, which is no obstacle', () => {
  const row = (done: number) =>
    checksOf(situation({ commissioned: { done, of: 8 } })).find(
      ({ name }) => name === 'commissioning',
    );
  expect(row(4)).toEqual({ name: 'commissioning', holds: null, text: '4 of 8 steps done' });
  expect(row(8)).toMatchObject({ holds: true });
  expect(obstacle(situation({ commissioned: { done: 0, of: 8 } }))).toBe('');
});
