import { expect, it } from 'vitest';
import { exampleStatus } from './example-status';
import { SteadyPhase } from './steady';

it('counts as in phase after a second without a break, and at once where it was so from the start', () => {
  const steady = new SteadyPhase();
  const locked = (phase_locked: boolean, at: number) =>
    steady.of(exampleStatus({}, { phase_locked }), at).loop.phase_locked;
  expect(locked(true, 0)).toBe(true);
  expect(locked(false, 200)).toBe(false);
  expect(locked(true, 400)).toBe(false);
  expect(locked(false, 1300)).toBe(false);
  expect(locked(true, 1500)).toBe(false);
  expect(locked(true, 2499)).toBe(false);
  expect(locked(true, 2500)).toBe(true);
  expect(locked(true, 2700)).toBe(true);
  expect(locked(false, 2900)).toBe(false);
});
