import { describe, expect, it, test } from 'vitest';
import {
  amount,
  atLimits,
  placeText,
  readChecked,
  stretches,
  timeText,
  title,
  type Violation,
  withUnit,
} from './feasibility';

function answer(more: object = { outline: null }): ArrayBuffer {
  const head = JSON.stringify({
    feasible: false,
    time: { start: 0, step: 0.01, count: 4 },
    columns: [
      { name: 'x.position', minimum: 0, maximum: 4 },
      { name: 'violated', minimum: 8, maximum: 12 },
    ],
    ...more,
  }).padEnd(240);
  const buffer = new ArrayBuffer(8 + 240 + 16 * 4);
  new DataView(buffer).setUint32(0, 240, true);
  new Uint8Array(buffer, 8, 240).set(new TextEncoder().encode(head));
  new Float32Array(buffer, 248).set([1, 2, 3, 4, 1, 2, 3, 4, 0, 1, 16, 0, 0, 1, 17, 0]);
  return buffer;
}

describe('a check', () => {
  it('is read without a copy', () => {
    const checked = readChecked(answer());
    expect(checked.feasible).toBe(false);
    expect([...(checked.columns.get('x.position')?.minimum ?? [])]).toEqual([1, 2, 3, 4]);
  });

  it('has the curve of a smooth path', () => {
    const { outline } = readChecked(answer({ outline: { x: 0, y: 8, edge: 12, count: 3 } }));
    const { x, y, edge } = outline ?? {};
    expect([x, y, edge].map((each) => Array.from(each ?? []))).toEqual([
      [1, 2, 3],
      [0, 1, 16],
      [0, 1, 17],
    ]);
    expect(readChecked(answer()).outline).toBeNull();
  });

  it('tells where which quantity is too large', () => {
    const checked = readChecked(answer());
    expect(stretches(checked)).toEqual([[1, 3]]);
    expect(stretches(checked, ['thrust'])).toEqual([[2, 3]]);
    expect(stretches(checked, ['velocity'])).toEqual([]);
  });
});

describe('words', () => {
  const violation: Violation = {
    quantity: 'thrust',
    axis: 'y',
    start: 0.4715,
    end: 0.5,
    time: 0.48,
    place: [0.0305, -0.00001],
    value: -43.2,
    limit: 28.06,
    unit: 'N',
  };

  it('say what, how much, where and when', () => {
    expect(title(violation)).toBe('y needs too much thrust');
    expect(amount(violation)).toBe('−43.2 N, allowed ±28.1 N');
    expect(placeText(violation.place)).toBe('x 30.50, y −0.01 mm');
    expect(timeText(violation)).toBe('0.471 to 0.500 s');
    expect(timeText({ ...violation, end: 0.4715 })).toBe('at 0.471 s');
  });
});

test('variants at a limit are named with the share of the time, others are not', () => {
  const free = { saturated_fraction: 0 };
  const variants = {
    A: { diverged: { time: 0.4 }, axes: { x: free, y: { saturated_fraction: null } } },
    B: { diverged: null, axes: { x: free, y: { saturated_fraction: 0.452 } } },
    C: { diverged: null, axes: { y: free } },
  };
  expect(atLimits(variants)).toEqual([
    'A diverges on this path.',
    'B has its command or currents at a limit 45 % of the time on y.',
  ]);
});

it('gives every acceleration in m/s²', () => {
  expect(withUnit(17.1, 'm/s^2')).toBe('17.1 m/s²');
  expect(withUnit(0.0658, 'm/s^2')).toBe('0.066 m/s²');
  expect(withUnit(0.199, 'm')).toBe('199 mm');
});
