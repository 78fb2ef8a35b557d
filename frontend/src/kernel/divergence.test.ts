import { expect, it } from 'vitest';
import { divergenceOf } from './divergence';

const CHANNELS = ['position', 'following_error'];
/** Ticks of x and y of both channels. */
const samples = (...ticks: number[][]) => Float32Array.from(ticks.flat());

it('names the axis with the larger error', () => {
  const { channel, last_states } = divergenceOf(
    samples([0, 0, 1, 1], [0, 0, 2, 3], [0, 0, 4, -5]),
    CHANNELS,
    2,
  );
  expect(channel).toBe('y.following_error');
  expect(last_states).toHaveLength(3);
  expect(last_states[2]).toMatchObject({ 'x.following_error': 4, 'y.following_error': -5 });
});

it('names the first channel that is not finite', () => {
  const { channel, last_states } = divergenceOf(
    samples([0, Number.NaN, 1, Number.POSITIVE_INFINITY]),
    CHANNELS,
    0,
  );
  expect(channel).toBe('y.position');
  expect(last_states).toEqual([
    { 'x.position': 0, 'y.position': 'nan', 'x.following_error': 1, 'y.following_error': 'inf' },
  ]);
});
