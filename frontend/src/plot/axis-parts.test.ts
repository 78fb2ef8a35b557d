import { expect, it } from 'vitest';
import { axisParts, endsOf } from './axis-parts';

const um = (low: number, high: number) => [low * 1e-6, high * 1e-6] as const;

it('a small error has an axis of its own, a round part of the first', () => {
  expect(axisParts([um(-20, 20), um(-0.9, 0.9)], [0, 0])).toEqual([0, 0.05]);
  expect(axisParts([um(-20, 20), um(-6, 6)], [0, 0])).toEqual([0, 0]);
});

it('the axis holds the run behind the small error', () => {
  const behind = endsOf([um(-0.9, 0.9), um(2, 2.6)]);
  expect(behind).toEqual(um(-0.9, 2.6));
  const [, part = 0] = axisParts([um(-20, 20), behind], [0, 0.05]);
  expect(part * 20e-6).toBeGreaterThanOrEqual(2.6e-6);
});

it('an axis stays while it fits', () => {
  expect(axisParts([um(-20, 20), um(-5, 5)], [0, 0.5])).toEqual([0, 0.5]);
  expect(axisParts([um(-20, 20), um(-0.1, 0.1)], [0, 0.5])).toEqual([0, 0.005]);
});

it('a curve without samples stays on the first axis', () => {
  const none = endsOf([[Infinity, -Infinity]]);
  expect(axisParts([um(-20, 20), none], [0, 0])).toEqual([0, 0]);
});
