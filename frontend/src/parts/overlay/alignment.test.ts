import { expect, it } from 'vitest';
import { alignedOffset, inStep, lapTime, type Motion } from './alignment';

const circle = { kind: 'circle', frequency: 1 / 3, radius: 0.015, laps: 3, lead_in: null };
const offset = (from: number, to: number, moving: boolean, other: object = {}) =>
  alignedOffset(
    { from, to },
    circle,
    { period: 0.0005, duration: 10.5, begin: 0, motion: circle as Motion, ...other },
    moving,
  );

it('a lap takes whole control periods; a path without a frequency has none', () => {
  expect(lapTime(circle, 0.0005)).toBeCloseTo(3, 9);
  expect(lapTime({ kind: 'circle', frequency: 0.7 }, 0.0005)).toBeCloseTo(1.4285, 9);
  expect(lapTime({ kind: 'polyline' }, 0.0005)).toBeNull();
});

it('motions are in step that differ in size and laps alone', () => {
  const other = (change: object): Motion => ({ ...circle, ...change });
  expect(inStep(circle, other({ radius: 0.02, laps: 5 }))).toBe(true);
  expect(inStep(circle, other({ frequency: 0.5 }))).toBe(false);
  expect(inStep(circle, other({ lead_in: 1 }))).toBe(false);
});

it('the last laps lie over a stretch that stays', () => {
  expect(offset(20.2, 20.4, false)).toBe(12);
  expect(offset(19.4, 19.5, false)).toBe(9);
  expect(offset(2, 4, false)).toBe(0);
});

it('the first laps lie over one that moves on, so that the run lasts', () => {
  expect(offset(20.2, 20.4, true)).toBe(18);
  expect(offset(100, 120, true)).toBe(111);
});

it('a recording that began later keeps its place in the lap', () => {
  expect(offset(20.2, 20.4, false, { begin: 11.2, duration: 0.2 })).toBe(20.2);
  expect(offset(20.2, 20.4, false, { begin: 12.7, duration: 0.2 })).toBeNull();
});

it('another motion is not aligned', () => {
  expect(offset(20.2, 20.4, false, { motion: { ...circle, frequency: 0.5 } })).toBeNull();
});
