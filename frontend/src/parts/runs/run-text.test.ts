import { expect, it } from 'vitest';
import { ApiError } from '../../app/api/client';
import type { Run, RunEvent } from '../../app/api/types';
import {
  differing,
  eventText,
  markText,
  movedText,
  searchProblem,
  sizeText,
  evictedText,
  stopText,
  stopWord,
  storageText,
  summary,
  timeOf,
  whenText,
} from './run-text';
import { durationText } from '../../ui/units';

const at = (...parts: [number, number, number, number, number]) =>
  new Date(...parts).getTime() / 1000;
const NOW = at(2026, 10, 20, 15, 30);
const event = (rest: Partial<RunEvent>) =>
  ({ tick: 0, set: {}, previous: {}, reason: '', ...rest }) as RunEvent;

it('events of a run whose beginning has gone are timed from its first sample', () => {
  const late = { first_tick: 80_000, period: 0.0005 };
  expect(timeOf(event({ tick: 80_000 }), late)).toBe(0);
  expect(timeOf(event({ tick: 84_000 }), late)).toBe(2);
  expect(timeOf(event({ kind: 'gap', tick: 0, ticks: 80_000 }), late)).toBe(-40);
  expect(timeOf(event({ tick: 84_000 }), { ...late, first_tick: 0 })).toBe(42);
});

it('says what stopped a run, with its symbols', () => {
  expect(stopText({ stopped: 'STOP', stopped_at: 4.2 })).toBe('Stopped at 4.2 s by STOP');
  const fault = { stopped: 'drive 3, 40 um off', stopped_at: null };
  expect(stopText(fault)).toBe('Fault: drive 3, 40 µm off');
  expect(stopWord({ ...fault, stopped_at: 12 })).toBe('fault at 12.0 s');
});

it('today is relative, yesterday has its time, what is older its date', () => {
  expect(whenText(NOW - 20, NOW)).toBe('just now');
  expect(whenText(NOW - 125, NOW)).toBe('2 min ago');
  expect(whenText(NOW - 3 * 3600, NOW)).toBe('3 h ago');
  expect(whenText(at(2026, 10, 19, 16, 5), NOW)).toBe('yesterday 16:05');
  expect(whenText(at(2026, 10, 12, 9, 0), NOW)).toBe('12 Nov');
  expect(whenText(at(2025, 10, 12, 9, 0), NOW)).toBe('12 Nov 2025');
  // Just after midnight an hour has not gone by.
  expect(whenText(at(2026, 10, 19, 23, 50), at(2026, 10, 20, 0, 10))).toBe('20 min ago');
});

it('differences have name, unit and numbers of the screen', () => {
  const path = 'variants.B.controller.x.k_p';
  expect(differing({ path, shipped: 200_300, value: 312_000 })).toEqual({
    name: 'B k_p x',
    text: '200.3 → 312 N/mm',
  });
  expect(differing({ path, shipped: null, value: 312_000 }).text).toBe('none → 312 N/mm');
  expect(differing({ path: 'variants.A', shipped: '{…}', value: null })).toEqual({
    name: 'A',
    text: 'left out',
  });
});

it('a replay says how far the largest errors have moved', () => {
  const error = { variant: 'B', axis: 'x', rms_recorded: 0, rms_simulated: 0, rms_change: 0 };
  const still = { ...error, axis: 'y', max_recorded: 1e-6, max_simulated: 1e-6, max_change: 0 };
  const moved = { ...error, max_recorded: 20.5e-6, max_simulated: 21.75e-6, max_change: 1.25e-6 };
  const gone = { ...error, max_recorded: 20.5e-6, max_simulated: null, max_change: null };
  expect(movedText({ errors: [moved, still] })).toEqual([
    'Largest error B x: +1.25 µm, 20.50 µm → 21.75 µm',
  ]);
  expect(movedText({ errors: [gone] })).toEqual(['Largest error B x: 20.50 µm → diverged']);
});

it('says what a run is where no field differs', () => {
  const run = { kind: 'simulation', state: 'complete', name: 'a', scenario: 'circle' } as Run;
  expect(summary({ ...run, differences: [] }, false)).toBe('as shipped: circle');
  expect(summary({ ...run, differences: [] }, true)).toBe('circle, a scenario of its own');
  const partial = { ...run, state: 'partial', reason: 'the disk was full' } as Run;
  expect(summary(partial, false)).toBe('partial: the disk was full');
});

it('events are words with units', () => {
  const set = { 'plant.x.mass': 6 };
  const change = event({ kind: 'change', set, previous: { 'plant.x.mass': 5 } });
  expect(eventText(change, 0.0005)).toBe('plant x mass 5 → 6 kg');
  expect(eventText({ ...change, by: 'Anna', undo: true }, 0.0005)).toBe(
    'undo: plant x mass 5 → 6 kg, by Anna',
  );
  const stop = event({ kind: 'stop', by: 'Guest 2', reason: '' });
  expect(eventText(stop, 0.0005)).toBe('stopped by Guest 2');
  const push = event({ kind: 'push', axis: 'x', force: 20, ticks: 100 });
  expect(eventText(push, 0.0005)).toBe('push x, 20.0 N for 50.0 ms');
  const gap = event({ kind: 'gap', ticks: 1000, reason: 'the disk was full' });
  expect(eventText(gap, 0.0005)).toBe('0.500 s are missing: the disk was full');
  const clock = (['play', 'pause', 'speed', 'reset'] as const).map((kind) => {
    const speed = kind === 'play' || kind === 'speed' ? 2 : null;
    return eventText(event({ kind, by: 'Anna', speed }), 0.0005);
  });
  expect(clock).toEqual([
    'play at 2 ×, by Anna',
    'paused by Anna',
    'speed 2 ×, by Anna',
    'reset by Anna',
  ]);
  expect([change, push, gap].map(markText)).toEqual(['plant x mass', 'push x', 'gap']);
});

it('sizes and lengths read between 1 and 1000', () => {
  expect([999, 2_302_667, 6.81e9].map(sizeText)).toEqual(['999 B', '2.30 MB', '6.81 GB']);
  expect([10.5, 243].map(durationText)).toEqual(['10.5 s', '4 min 3 s']);
  const storage = {
    runs: 1284,
    size: 6.81e9,
    kept_size: 2.1e8,
    recording_size: 0,
    quota: 1e10,
    evicted: [] as object[],
  };
  expect(storageText(storage as never)).toBe(
    '6.81 GB of 10.0 GB in 1,284 runs, 210 MB of it kept or pinned.',
  );
  const recording = { ...storage, runs: 1, recording_size: 1e9 };
  expect(storageText(recording as never)).toBe(
    '7.81 GB of 10.0 GB in 1 run, 210 MB of it kept or pinned, and 1.00 GB being recorded.',
  );
  expect(evictedText(storage as never, 0)).toBe('');
  storage.evicted = [
    { name: 'circle', created: NOW - 7200, evicted: NOW - 60 },
    { name: 'rhombus', created: NOW - 7300, evicted: NOW - 61 },
    { name: 'long ago', created: NOW - 1e6, evicted: NOW - 9e5 },
  ];
  expect(evictedText(storage as never, NOW)).toBe(
    `Evicted ${whenText(NOW - 60, NOW)}: circle, recorded ${whenText(NOW - 7200, NOW)} and ` +
      '1 other. Name, note, tag or pin what is to stay.',
  );
});

it('a refused search names the term and what is allowed', () => {
  const errors = [{ loc: 'q', message: 'unknown', value: 'kind:car', range: 'one of live' }];
  const refused = new ApiError({ title: '', status: 422, detail: '', errors });
  expect(searchProblem(refused)).toBe('“kind:car” unknown. Allowed: one of live.');
  expect(searchProblem(new Error('away'))).toBe('');
});
