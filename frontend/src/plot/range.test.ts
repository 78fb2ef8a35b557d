import { describe, expect, it } from 'vitest';
import { calmRange, fit, multiples, roundStep } from './range';

it('rounds steps to 1, 2, 5', () => {
  expect([0.7, 1.3, 2, 3.1, 7e-6].map(roundStep)).toEqual([1, 2, 2, 5, 1e-5]);
});

it('lists multiples, zero without a sign', () => {
  expect(multiples({ from: -0.25, to: 0.2 }, 0.1)).toEqual([-0.2, -0.1, 0, 0.1, 0.2]);
});

describe('fit', () => {
  it('leaves some room between round ends', () => {
    const range = fit(-20.4e-6, 20.5e-6);
    expect(range.from).toBeCloseTo(-25e-6, 12);
    expect(range.to).toBeCloseTo(25e-6, 12);
  });
  it('gives a constant a range', () => {
    const range = fit(0.015, 0.015);
    expect(range.from).toBeLessThan(0.015);
    expect(range.to).toBeGreaterThan(0.015);
  });
  it('does not go beyond zero for what has one sign', () => {
    expect(fit(0, 1.9).from).toBe(0);
    expect(fit(-1.9, -0.01).to).toBe(0);
  });
  it('takes nothing for something', () => {
    expect(fit(Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY)).toEqual({ from: -1, to: 1 });
    expect(fit(0, 0)).toEqual({ from: -0.1, to: 0.1 });
    expect(fit(0, 0, 1e-5)).toEqual({ from: -1e-6, to: 1e-6 });
  });
});

describe('calmRange', () => {
  const present = { from: -30, to: 30 };
  it('stays while the data fit', () => expect(calmRange(present, -21, 25)).toBe(present));
  it('grows at once', () => expect(calmRange(present, -21, 31).to).toBeGreaterThan(31));
  it('shrinks when it is far too large', () =>
    expect(calmRange(present, -2, 2).to).toBeLessThan(4));
});
