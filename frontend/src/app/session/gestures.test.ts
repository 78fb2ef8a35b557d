import { expect, it } from 'vitest';
import type { Changes } from '../api/types';
import { Gestures } from './gestures';

/** A session's changes as the server lists them. */
const listed = (...sets: Changes[]) => sets.map((set) => ({ tick: 0, set, previous: {} }));

function send(gestures: Gestures, takes = true): Changes | undefined {
  const sending = gestures.next();
  if (takes) sending?.taken();
  sending?.done();
  return sending?.set;
}

it('sends the values of one gesture at a time, the newest of each', () => {
  const gestures = new Gestures();
  gestures.put({ a: 1 }, true);
  gestures.put({ a: 2 }, false);
  gestures.put({ b: 1 }, true);
  expect(gestures.unsent).toEqual({ a: 2, b: 1 });
  expect(send(gestures)).toEqual({ a: 2 });
  expect(gestures.unsent).toEqual({ b: 1 });
  expect(send(gestures)).toEqual({ b: 1 });
  expect(gestures.next()).toBeNull();
});

it('keeps a value that was set while an older one was on its way', () => {
  const gestures = new Gestures();
  gestures.put({ a: 1, c: 1 }, true);
  const sending = gestures.next();
  gestures.put({ a: 2 }, false);
  sending?.taken();
  sending?.done();
  expect(gestures.unsent).toEqual({ a: 2 });
});

it('takes back all changes of the last gesture, then those of the one before', () => {
  const gestures = new Gestures();
  for (const a of [1, 2, 3]) {
    gestures.put({ a }, a === 1);
    send(gestures);
  }
  gestures.put({ b: 1 }, true);
  send(gestures);
  expect(gestures.take(listed({ a: 1 }, { a: 2 }, { a: 3 }, { b: 1 }))).toBe(1);
  expect(gestures.take(listed({ a: 1 }, { a: 2 }, { a: 3 }))).toBe(3);
});

it('passes over a gesture that the session has not taken', () => {
  const gestures = new Gestures();
  for (const a of [1, 2]) {
    gestures.put({ a }, a === 1);
    send(gestures);
  }
  gestures.put({ a: -5 }, true);
  send(gestures, false);
  expect(gestures.take(listed({ a: 1 }, { a: 2 }))).toBe(2);
});

it('takes back one change where the last one came from elsewhere, and the gesture after it', () => {
  const gestures = new Gestures();
  for (const a of [1, 2]) {
    gestures.put({ a }, a === 1);
    send(gestures);
  }
  expect(gestures.take(listed({ a: 1 }, { a: 2 }, { c: 9 }))).toBe(1);
  expect(gestures.take(listed({ a: 1 }, { a: 2 }))).toBe(2);
  expect(gestures.take(listed({ z: 1 }, { z: 2 }))).toBe(1);
});

it('forgets a gesture that another tab has taken back', () => {
  const gestures = new Gestures();
  gestures.put({ a: 1 }, true);
  send(gestures);
  gestures.put({ b: 1 }, true);
  send(gestures);
  expect(gestures.take(listed({ a: 1 }))).toBe(1);
});

it('knows a change by what was sent, whatever label the server has added', () => {
  const gestures = new Gestures();
  for (const name of ['pd', 'lugre']) {
    gestures.put({ 'variants.B.controller': name }, name === 'pd');
    send(gestures);
  }
  const changes = ['pd', 'lugre'].map((name) => ({
    'variants.B.controller': name,
    'variants.B.label': name,
  }));
  expect(gestures.take(listed(...changes))).toBe(2);
});
