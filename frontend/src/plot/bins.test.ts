import { describe, expect, it } from 'vitest';
import { cut, pointsOf, writeCurve, type Bins } from './bins';

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

describe('writeCurve', () => {
  const bins = { first: 0, size: 2, count: 4, paired: true };
  const gap = Number.NaN;
  const curve = (of: Bins, minimum: number[], maximum: number[]) => {
    const values = new Float32Array(pointsOf(of));
    writeCurve(of, Float32Array.from(minimum), Float32Array.from(maximum), values);
    return [...values];
  };
  it('keeps both extremes and follows the slope', () =>
    expect(curve(bins, [0, 2, 1, -9], [1, 3, 2, -8])).toEqual([0, 1, 2, 3, 2, 1, -8, -9]));
  it('leaves gaps', () =>
    expect(curve(bins, [0, gap, 1, 2], [1, gap, 2, 3])).toEqual([0, 1, gap, gap, 1, 2, 2, 3]));
  it('passes samples on', () => {
    const samples = [4, gap, 5];
    const single = { first: 0, size: 1, count: 3, paired: false };
    expect(curve(single, samples, samples)).toEqual(samples);
  });
});
