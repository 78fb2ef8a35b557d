import { describe, expect, it } from 'vitest';
import { cut, writeCurve, writeTimes, type Points } from './bins';

describe('cut', () => {
  it('makes about as many bins as pixels, aligned to their size', () => {
    expect(cut(1003, 21003, 800)).toEqual({ first: 992, size: 32, count: 626, paired: true });
    expect(cut(0, 500, 800)).toEqual({ first: 0, size: 1, count: 500, paired: false });
  });
  it('keeps the borders of bins while the window slides', () => {
    const a = cut(10_000, 30_000, 900);
    const b = cut(10_037, 30_037, 900);
    expect(b.size).toBe(a.size);
    expect((b.first - a.first) % a.size).toBe(0);
  });
  it('makes one bin of nothing', () => expect(cut(7, 7, 100).count).toBe(1));
});

describe('writeTimes', () => {
  it('gives each bin its start and its middle', () => {
    const times: number[] = [];
    writeTimes({ first: 8, size: 4, count: 2, paired: true }, 1, 0.5, times);
    expect(times).toEqual([5, 6, 7, 8]);
  });
  it('gives each sample its time', () => {
    const times = [9, 9, 9, 9];
    writeTimes({ first: 3, size: 1, count: 2, paired: false }, 0, 0.5, times);
    expect(times).toEqual([1.5, 2]);
  });
});

describe('writeCurve', () => {
  const bins = { first: 0, size: 2, count: 4, paired: true };
  it('keeps both extremes and follows the slope', () => {
    const values: Points = [];
    writeCurve(bins, Float32Array.of(0, 2, 1, -9), Float32Array.of(1, 3, 2, -8), values);
    expect(values).toEqual([0, 1, 2, 3, 2, 1, -8, -9]);
  });
  it('leaves gaps', () => {
    const values: Points = [];
    const gap = Number.NaN;
    writeCurve(bins, Float32Array.of(0, gap, 1, 2), Float32Array.of(1, gap, 2, 3), values);
    expect(values).toEqual([0, 1, null, null, 1, 2, 2, 3]);
  });
  it('passes samples on', () => {
    const values: Points = [];
    const samples = Float32Array.of(4, Number.NaN, 5);
    writeCurve({ first: 0, size: 1, count: 3, paired: false }, samples, samples, values);
    expect(values).toEqual([4, null, 5]);
  });
});
