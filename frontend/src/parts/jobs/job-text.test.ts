import { expect, it } from 'vitest';
import { duration, moment, trouble } from './job-text';

it('writes times as short as they are needed', () => {
  expect(duration(0.4)).toBe('under 1 s');
  expect(duration(12.4)).toBe('12 s');
  expect(duration(119)).toBe('119 s');
  expect(duration(180)).toBe('3 min');
});

it('leaves out the day where it is today', () => {
  const now = new Date(2026, 0, 2, 12);
  const today = moment(new Date(2026, 0, 2, 8).toISOString(), now);
  const before = moment(new Date(2026, 0, 1, 8).toISOString(), now);
  expect(before.endsWith(` ${today}`)).toBe(true);
});

it('says why there is no result', () => {
  expect(trouble({ state: 'failed', error: 'the motor diverged' })).toBe(
    'failed. the motor diverged',
  );
  expect(trouble({ state: 'interrupted', error: 'the server ended' })).toBe(
    'was interrupted: the server ended',
  );
  expect(trouble({ state: 'done', error: null })).toBeNull();
});
