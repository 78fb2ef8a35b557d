import { expect, it } from 'vitest';
import { magnification } from './plane';

it('magnifies errors to a visible, round size', () => {
  expect(magnification(0.03, 20.5e-6)).toBe(200);
  expect(magnification(0.03, 2.6e-6)).toBe(2000);
  expect(magnification(2.5e-6, 0.5e-6)).toBe(1);
});

it('magnifies nothing when there is no error', () => {
  expect(magnification(0.03, 0)).toBe(1);
  expect(magnification(0, Number.NaN)).toBe(1);
});
