import { expect, it } from 'vitest';
import { contour } from './contours';

const xs = Array.from({ length: 21 }, (_, i) => 10 ** (i / 10));
const ys = Array.from({ length: 17 }, (_, j) => 10 ** (j / 8));
const over = (f: (x: number, y: number) => number) =>
  ys.map((y) => xs.map((x) => f(Math.log10(x), Math.log10(y))));

it('finds a straight line where it is, in one piece', () => {
  const { x, y } = contour(xs, ys, over((u, v) => u + v), 2.03); // prettier-ignore
  expect(x.filter((at) => at === null)).toHaveLength(1);
  x.forEach((at, k) => {
    if (at !== null) expect(Math.log10(at) + Math.log10(y[k] ?? NaN)).toBeCloseTo(2.03, 9);
  });
});

it('closes a ring, and keeps two of them apart', () => {
  const ring = (u: number, v: number, at: number) => Math.hypot(u - at, v - 1);
  const both = over((u, v) => Math.min(ring(u, v, 0.5), ring(u, v, 1.5)));
  const { x, y } = contour(xs, ys, both, 0.31);
  const gaps = x.flatMap((at, k) => (at === null ? [k] : []));
  expect(gaps).toHaveLength(2);
  expect([x[0], y[0]]).toEqual([x[(gaps[0] ?? 0) - 1], y[(gaps[0] ?? 0) - 1]]);
});

it('goes half way to what is infinite', () => {
  const { x } = contour([1, 100], [1, 100], [[0, Infinity], [0, Infinity]], 1); // prettier-ignore
  expect(x[0]).toBeCloseTo(10);
});
