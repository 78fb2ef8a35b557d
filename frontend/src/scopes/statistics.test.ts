import { expect, it } from 'vitest';
import { Ring } from '../app/stream/ring';
import { StillSource } from '../plot/source';
import { LiveSource } from './live-source';
import { between, statistics } from './statistics';

const STEP = 0.0005;

function live(values: readonly number[], tick = 0): LiveSource {
  const ring = new Ring(4096, ['e']);
  ring.write(tick, [new Float32Array(values)]);
  return new LiveSource(
    () => ring,
    () => STEP,
  );
}

it('are those of every sample within the range', () => {
  // Two periods of 3 + sin; the second half of the ring is outside of the range.
  const wave = Array.from({ length: 4000 }, (_, i) =>
    i < 2000 ? 3 + Math.sin((2 * Math.PI * i) / 1000) : 99,
  );
  const figures = statistics(live(wave), 'e', { from: 0, to: 1 });
  expect(figures.mean).toBeCloseTo(3, 6);
  expect(figures.deviation).toBeCloseTo(Math.SQRT1_2, 6);
  expect(figures.rms).toBeCloseTo(Math.sqrt(9.5), 6);
  expect(figures.span).toBeCloseTo(2, 6);
});

it('leave gaps out', () => {
  const { mean, span } = statistics(live([1, Number.NaN, 4]), 'e', { from: 0, to: 1 });
  expect([mean, span]).toEqual([2.5, 3]);
});

it('take a curve as even between the extremes of a bin', () => {
  // A ramp from 0 to 8 in four bins: mean 4, mean square 64/3.
  const envelope = {
    minimum: new Float32Array([0, 2, 4, 6]),
    maximum: new Float32Array([2, 4, 6, 8]),
  };
  const source = new StillSource(10, 1, 4, new Map([['e', envelope]]));
  const figures = statistics(source, 'e', { from: 0, to: 20 });
  expect(figures.mean).toBe(4);
  expect(figures.rms ** 2).toBeCloseTo(64 / 3, 9);
  expect(figures.span).toBe(8);
});

it('are not there where nothing is', () => {
  const figures = statistics(live([1, 2]), 'e', { from: 5, to: 6 });
  expect(Object.values(figures).every((value) => !Number.isFinite(value))).toBe(true);
});

it('both cursors’ samples are part of what is measured between them', () => {
  const at = (k: number) => k * 5e-4;
  // Floor of the quotient alone would put 3 periods of 0.5 ms before the third sample.
  expect(between([at(45) + 2e-4, at(3)], 5e-4)).toEqual({ from: at(3), to: at(46) });
  expect(between([at(7), at(7)], 5e-4)).toEqual({ from: at(7), to: at(8) });
});
