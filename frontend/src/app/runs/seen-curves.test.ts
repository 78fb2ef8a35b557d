import { expect, it } from 'vitest';
import { StillSource } from '../../plot/source';
import { SeenCurves } from './seen-curves';

const curves = (start: number, step: number, count: number) =>
  new StillSource(start, step, count, new Map());

const whole = curves(0, 0.1, 2400);
const fine = curves(0, 0.01, 24_000);
const part = curves(50, 0.001, 10_000);

it('draws from the coarsest that is fine enough, else from the finest that covers', () => {
  const seen = new SeenCurves();
  for (const each of [fine, whole, part]) seen.put(['a', 'b'], each);
  const best = (from: number, to: number, step: number) => seen.best(['a'], { from, to }, step);
  expect(best(0, 240, 0.2)).toBe(whole);
  expect(best(0, 24, 0.02)).toBe(fine);
  expect(best(52, 54, 0.002)).toBe(part);
  expect(best(52, 54, 0.0001)).toBe(part);
  // It stays while it will do, so that nothing is drawn again for curves that came meanwhile.
  seen.put(['a'], curves(50, 0.001, 10_000));
  expect(best(52, 54, 0.002)).toBe(part);
  expect(best(49, 54, 0.0001)).toBe(fine);
  expect(best(-5, 54, 0.1)).toBeNull();
  expect(seen.best(['a', 'other'], { from: 0, to: 1 }, 1)).toBeNull();
});

it('keeps within its bound what was used last, and always the newest', () => {
  const bytes = 8 * 100;
  const seen = new SeenCurves(3 * bytes);
  const at = (start: number) => ({ from: start, to: start + 1 });
  const pieces = [0, 10, 20, 30].map((start) => curves(start, 0.01, 100));
  for (const each of pieces.slice(0, 3)) seen.put(['a'], each);
  seen.best(['a'], at(0), 1);
  seen.put(['a'], pieces[3] as StillSource);
  expect(seen.bytes).toBe(3 * bytes);
  const there = [0, 10, 20, 30].filter((start) => seen.best(['a'], at(start), 1));
  expect(there).toEqual([0, 20, 30]);
  seen.put(['a'], curves(0, 0.01, 10_000));
  expect(seen.bytes).toBeLessThanOrEqual(8 * 10_000 + bytes);
});
