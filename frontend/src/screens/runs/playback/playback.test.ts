import { expect, it } from 'vitest';
import { advanced, otherSpeed } from './playback';

it('plays at its speed, to the end and no further', () => {
  const playing = { elapsed: 0.1, speed: 2, end: 10 };
  expect(advanced(3, playing)).toEqual({ time: 3.2, ended: false });
  expect(advanced(9.9, playing)).toEqual({ time: 10, ended: true });
  expect(advanced(3, { ...playing, elapsed: 60 }).time).toBe(3.5);
});

it('goes through the speeds', () => {
  expect(otherSpeed(1, 1)).toBe(2);
  expect(otherSpeed(10, 1)).toBe(10);
  expect(otherSpeed(0.1, -1)).toBe(0.1);
});
