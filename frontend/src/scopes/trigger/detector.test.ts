import { expect, test } from 'vitest';
import { Detector, type Condition, type Join } from './detector';

const PERIOD = 5e-4;

function hits(
  conditions: Condition[],
  samples: number[][],
  { join = 'or' as Join, holdOff = 0, marks = [] as number[] } = {},
): number[] {
  const detector = new Detector(conditions, join, holdOff, () => marks, PERIOD);
  return samples.flatMap((values, tick) => (detector.next(tick, values) ? [tick] : []));
}

const alone = (values: number[]) => values.map((value) => [value]);
const level = (slope: 'rising' | 'falling' | 'either', hysteresis = 0): Condition => ({
  kind: 'level',
  channel: 'x',
  slope,
  level: 1,
  hysteresis,
});

test('a level triggers where it is passed in its direction', () => {
  const values = alone([0, 0.5, 1, 2, 1.5, 0.5, 1, 0]);
  expect(hits([level('rising')], values)).toEqual([2, 6]);
  // Met from above only: at 6 the level is reached from below.
  expect(hits([level('falling')], values)).toEqual([5]);
  expect(hits([level('either')], values)).toEqual([2, 5, 6, 7]);
});

test('a curve that begins beyond a level has not passed it', () => {
  expect(hits([level('rising')], alone([2, 2, 0, 2]))).toEqual([3]);
});

test('hysteresis keeps counts of an encoder from triggering', () => {
  const chatter = alone([0, 1, 0.9, 1, 0.9, 1, 0.4, 1]);
  expect(hits([level('rising')], chatter)).toEqual([1, 3, 5, 7]);
  expect(hits([level('rising', 0.5)], chatter)).toEqual([1, 7]);
  const down = alone([2, 1, 1.1, 1, 1.6, 1]);
  expect(hits([level('falling', 0.5)], down)).toEqual([1, 5]);
});

test('a window is left and entered, with hysteresis inside', () => {
  const window = (way: 'leaves' | 'enters', hysteresis = 0): Condition => ({
    kind: 'window',
    channel: 'x',
    way,
    low: -1,
    high: 1,
    hysteresis,
  });
  const values = alone([0, 1.5, 0.95, 1.5, 0, -2, 0]);
  expect(hits([window('leaves')], values)).toEqual([1, 3, 5]);
  expect(hits([window('leaves', 0.2)], values)).toEqual([1, 5]);
  expect(hits([window('enters')], values)).toEqual([2, 4, 6]);
});

test('a reversal comes after a rest too, and never twice', () => {
  const values = alone([1, 1, 0, 0, -1, -1, 0, -1, 1]);
  const turns = (slope: 'rising' | 'falling' | 'either') =>
    hits([{ kind: 'reversal', channel: 'x', slope }], values);
  expect(turns('either')).toEqual([4, 8]);
  expect(turns('rising')).toEqual([8]);
  expect(turns('falling')).toEqual([4]);
});

test('and: one begins while the others hold', () => {
  const conditions: Condition[] = [
    { kind: 'reversal', channel: 'v', slope: 'either' },
    { ...(level('rising') as object), channel: 'e' } as Condition,
  ];
  const samples = [
    [1, 0],
    [-1, 0], // a reversal, while the level is not reached
    [-1, 2], // reached, but nothing reverses
    [1, 2],
    [-1, 0],
  ];
  expect(hits(conditions, samples, { join: 'and' })).toEqual([3]);
  expect(hits(conditions, samples, { join: 'or' })).toEqual([1, 2, 3, 4]);
});

test('nothing triggers within the hold-off', () => {
  const values = alone([0, 1, 0, 1, 0, 1, 0, 1]);
  expect(hits([level('rising')], values, { holdOff: 4 })).toEqual([1, 5]);
});

test('a gap triggers nothing', () => {
  expect(hits([level('rising')], alone([0, Number.NaN, 2]))).toEqual([2]);
  expect(hits([level('falling')], alone([2, Number.NaN, 2]))).toEqual([]);
});

test('what is marked triggers at its tick', () => {
  expect(hits([{ kind: 'mark' }], alone([0, 0, 0, 0]), { marks: [1e-3] })).toEqual([2]);
});
