import { expect, it } from 'vitest';
import type { RunEvent, SessionInfo } from '../api/types';
import { clockMarks } from './clock-marks';
import { lawMark, lawText } from './law-text';
import { gathered, Moments, newLaw, newReset, newStop, type Made } from './moments.svelte';

function made(time: number, set: object, others: Partial<Made> = {}): Made {
  return { time, set, undone: false, by: '', ...others };
}

function event(kind: RunEvent['kind'], tick: number, others: Partial<RunEvent> = {}): RunEvent {
  return { kind, tick, by: '', undo: false, reason: '', ...others } as RunEvent;
}

function at(events: readonly RunEvent[], timeline = 1): SessionInfo {
  return { timeline, events } as unknown as SessionInfo;
}

it('gathers the changes of a drag into one, at its end', () => {
  const drag = [1, 1.4, 1.9, 2.6].map((time, k) => made(time, { k_p: k }));
  const later = made(4, { k_d: 1 });
  expect(gathered([...drag, later], 1)).toEqual([made(2.6, { k_p: 3 }), later]);
  const both = gathered([made(1, { k_p: 1 }), made(1.5, { k_d: 2 })], 1);
  expect(both).toEqual([made(1.5, { k_p: 1, k_d: 2 })]);
});

it('keeps changes of different people, and what was undone, apart', () => {
  const apart = [
    made(1, { k_p: 1 }),
    made(1.1, { k_p: 2 }, { by: 'Guest 2' }),
    made(1.2, { k_p: 1 }, { by: 'Guest 2', undone: true }),
  ];
  expect(gathered(apart, 1)).toEqual(apart);
});

it('has times once the period is known', () => {
  const moments = new Moments();
  const set = { k_p: 3 };
  moments.events = [
    event('change', 6000, { set }),
    event('change', 10_000, { set, undo: true, by: 'Anna' }),
    event('push', 11_000),
  ];
  expect(moments.changes).toEqual([]);
  moments.period = 0.0005;
  expect(moments.changes).toEqual([made(3, set), made(5, set, { undone: true, by: 'Anna' })]);
  expect(moments.of('push').map(({ time }) => time)).toEqual([5.5]);
});

it('tells a stop that has just come from one that was there', () => {
  const stop = event('stop', 8400, { by: 'Guest 2' });
  expect(newStop(at([]), at([stop]))).toBe(stop);
  expect(newStop(at([stop]), at([stop]))).toBeNull();
  expect(newStop(at([stop]), at([stop], 2))).toBe(stop);
  expect(newStop(at([stop]), at([event('push', 2)]))).toBeNull();
});

it('tells a law’s file that was just saved, again where it is saved with the same mistake', () => {
  const law = { law: 'mine', reason: '/home/my laws/mine.py:7: mine: SyntaxError: no' };
  const [first, again] = [event('law', 0, { ...law, at: 1 }), event('law', 0, { ...law, at: 2 })];
  expect(newLaw(at([]), at([event('push', 2)]))).toBeNull();
  expect(newLaw(at([]), at([first]))).toBe(first);
  expect(newLaw(at([first]), at([first, event('push', 2)]))).toBeNull();
  expect(newLaw(at([first]), at([first, again]))).toBe(again);
  expect(lawText(first)).toBe('law mine not taken: mine.py:7: mine: SyntaxError: no');
  expect(lawMark(first)).toBe('law mine not taken');
  const taken = { ...first, reason: '' };
  expect(lawText(taken)).toBe('law mine: a new version');
  expect(lawText({ ...taken, version: 2 })).toBe('law mine, version 2');
  const jump = { B: { x: 0.4213, y: -0.1 } };
  const text = 'law mine, version 2: +0.42 N on x, −0.10 N on y';
  expect(lawText({ ...taken, version: 2, jump })).toBe(text);
  expect(lawMark({ ...taken, version: 2, jump })).toBe(text);
  const both = { A: { x: 2e-5, y: 0 }, B: { x: 1, y: 0 } };
  expect(lawMark({ ...taken, version: 3, jump: both })).toBe(
    'law mine, version 3: A no jump in force; B +1.0 N on x',
  );
});

it('tells a reset that has just come', () => {
  const reset = event('reset', 0, { by: 'Anna' });
  expect(newReset(at([], 1), at([reset], 2))).toBe(reset);
  expect(newReset(at([reset], 2), at([reset, event('push', 2)], 2))).toBeNull();
  expect(newReset(at([], 1), at([], 2))).toBeNull();
});

it('marks speeds, and who else moved the clock, once a tick', () => {
  const other = (by: string | undefined) => (!by || by === 'me' ? '' : ` by ${by}`);
  const marks = (...events: RunEvent[]) =>
    clockMarks(events, other).map(({ tick, label }) => `${tick} ${label}`);
  expect(marks(event('play', 0, { by: 'me' }), event('pause', 9, { by: 'me' }))).toEqual([]);
  expect(marks(event('play', 0), event('pause', 9), event('reset', 0))).toEqual([]);
  expect(
    marks(
      event('reset', 0, { by: 'Anna' }),
      event('play', 0, { by: 'me', speed: 0.25 }),
      event('change', 5, { by: 'Anna' }),
      event('speed', 9, { by: 'me', speed: 3 }),
      event('speed', 9, { by: 'Anna', speed: 2 }),
    ),
  ).toEqual(['0 reset by Anna; speed 0.25 ×', '9 speed 2 × by Anna']);
  const again = ['pause', 'play', 'pause'] as const;
  expect(
    marks(
      ...again.map((kind) => event(kind, 7, { by: 'Anna' })),
      event('play', 7, { by: 'Ben', speed: 2 }),
    ),
  ).toEqual(['7 pause, play by Anna; play, speed 2 × by Ben']);
});
