import { expect, it } from 'vitest';
import { duration, moment, originOf, progressOf, trouble } from './job-text';

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

it('says of a shipped result which version it came with and which day it is of', () => {
  const created = '2026-11-27T12:00:00Z';
  const job = { created, elapsed: 200, version: '0.1.0', shipped: true };
  expect(originOf(job)).toBe('Shipped with 0.1.0, computed on 27 November 2026');
  expect(originOf({ ...job, shipped: false })).toMatch(/took 3 min$/);
});

it('says how far a job is, and what one in the queue waits for', () => {
  const job = { state: 'running', progress: 0.129, remaining: null, waits_for: null } as const;
  expect(progressOf(job)).toBe('12\u00a0%');
  expect(progressOf({ ...job, remaining: 40 })).toBe('12\u00a0%, about 40 s left');
  expect(progressOf({ ...job, remaining: 0.5 })).toBe('12\u00a0%, under 1 s left');
  const queued = { ...job, state: 'queued' } as const;
  expect(progressOf({ ...queued, waits_for: 'memory' })).toContain('waits for memory');
  expect(progressOf({ ...queued, waits_for: 'kernels' })).toContain('compiled');
});
