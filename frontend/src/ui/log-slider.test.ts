import { describe, expect, it } from 'vitest';
import { position, valueAfterKey, valueAt } from './log-slider';

const scale = { least: 1e4, most: 1e7 };

describe('slider', () => {
  it('is logarithmic', () => {
    expect(position(1e5, scale)).toBeCloseTo(1 / 3, 12);
    expect(valueAt(1 / 3, scale)).toBe(1e5);
  });
  it('goes there and back', () => {
    for (const value of [1e4, 200300, 312000, 1e7]) {
      expect(valueAt(position(value, scale), scale)).toBeCloseTo(value, -2);
    }
  });
  it('stays on its track', () => {
    expect([0, -1, Number.NaN, 1e9].map((value) => position(value, scale))).toEqual([0, 0, 0, 1]);
    expect([valueAt(-1, scale), valueAt(2, scale)]).toEqual([1e4, 1e7]);
  });
});

describe('keys', () => {
  it('step by a share of the value', () => {
    expect(valueAfterKey('ArrowRight', false, 200000, scale)).toBe(202000);
    expect(valueAfterKey('ArrowUp', true, 200000, scale)).toBe(220000);
    expect(valueAfterKey('ArrowLeft', false, 202000, scale)).toBe(200000);
    expect(valueAfterKey('PageDown', false, 220000, scale)).toBe(200000);
  });
  it('stop at the ends', () => {
    expect(valueAfterKey('ArrowRight', true, 9.9e6, scale)).toBe(1e7);
    expect(valueAfterKey('Home', false, 2e5, scale)).toBe(1e4);
    expect(valueAfterKey('End', false, 2e5, scale)).toBe(1e7);
  });
  it('leave other keys alone', () => expect(valueAfterKey('a', false, 1, scale)).toBeNull());
});
