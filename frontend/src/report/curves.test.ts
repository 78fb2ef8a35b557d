import { describe, expect, it } from 'vitest';
import { differenceOf } from './difference';
import { pathOf } from './svg-path';

describe('the path of a curve', () => {
  const drawn = (low: readonly number[], high: readonly number[]) =>
    pathOf(
      low.length,
      (bin) => 10 * bin,
      (bin) => low[bin] as number,
      (bin) => high[bin] as number,
    );

  it('passes through both ends of a bin, the nearer first', () => {
    expect(drawn([1, 1, 5], [1, 4, 6])).toBe('M0 1L10 1V4L20 5V6');
    expect(drawn([4, 1], [4, 3])).toBe('M0 4L10 3V1');
  });

  it('has a gap where a bin has no number', () => {
    expect(drawn([1, Number.NaN, 2], [1, 1, 2])).toBe('M0 1M20 2');
  });
});

describe('the difference of two curves', () => {
  it('keeps the extremes of each bin', () => {
    const [a, b] = [new Float32Array([3, 1, 2, 9, 4]), new Float32Array([1, 1, 4, 1, 4])];
    const { minimum, maximum } = differenceOf(a, b, 2);
    expect([...minimum]).toEqual([0, -2, 0]);
    expect([...maximum]).toEqual([2, 8, 0]);
  });

  it('is none where one is none', () => {
    const { minimum } = differenceOf(new Float32Array([1, Number.NaN]), new Float32Array(2), 2);
    expect(minimum[0]).toBeNaN();
  });
});
