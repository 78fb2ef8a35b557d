import { expect, test } from 'vitest';
import { largest } from './live-plane';

test('the largest error of each bin is drawn, and both ends', () => {
  const x = [0, 3, 0, 0, 0, -5, 0, 1, 0];
  const y = [0, 4, 0, 0, 9, 0, 0, 0, 0];
  expect(largest(x, y, 3)).toEqual([0, 1, 4, 7, 8]);
  expect(largest(x, y, 100)).toEqual([0, 1, 2, 3, 4, 5, 6, 7, 8]);
});

test('a bin after a divergence has its first sample', () => {
  expect(largest([1, 2, NaN, NaN], [0, 0, NaN, NaN], 2)).toEqual([0, 1, 2, 3]);
});
