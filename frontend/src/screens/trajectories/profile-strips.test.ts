import { expect, it } from 'vitest';
import { tightest } from './profile-strips';

it('draws the least of rippling limits, in bins wider than a pixel', () => {
  const forward = Float32Array.from({ length: 1000 }, (_, i) => 40 + (i % 7));
  const backward = forward.map((value) => -value);
  const [low, high] = tightest({ minimum: backward, maximum: forward }, 10);
  expect(low).toHaveLength(100);
  expect(new Set(high)).toEqual(new Set([40]));
  expect(new Set(low)).toEqual(new Set([-40]));
  expect(tightest({ minimum: backward, maximum: forward }, 1)[1]).toEqual(forward);
});
