import { expect, it } from 'vitest';
import { StillSource } from '../../plot/source';
import { peaks } from './reference-peaks';

it('finds peaks and their share of the limits', () => {
  const flat = (low: number, high: number) => ({
    minimum: Float32Array.of(0, low),
    maximum: Float32Array.of(high, 0),
  });
  const source = new StillSource(
    0,
    1,
    2,
    new Map([
      ['x.velocity_reference', flat(-0.5, 0.25)],
      ['y.velocity_reference', flat(0, 0)],
      ['x.acceleration_reference', flat(0, 1)],
      ['y.acceleration_reference', flat(-2, 1)],
    ]),
  );
  const limits = { velocity_max: 1, acceleration_max: 2.5 };
  const largest = peaks(source, { x: limits, y: limits });
  expect(largest).toEqual({ velocity: 0.5, acceleration: 2, share: 0.8 });
});
