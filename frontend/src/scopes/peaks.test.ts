import { expect, it } from 'vitest';
import { Turns } from './peaks';

function turnsOf(values: readonly number[], prominence: number): number[] {
  const turns = new Turns(prominence);
  return values.flatMap((value, place) => turns.next(place, value)?.place ?? []);
}

it('finds largest and least alike, at their own samples', () => {
  const sine = Array.from({ length: 1000 }, (_, i) => Math.sin((2 * Math.PI * i) / 200));
  expect(turnsOf(sine, 0.2)).toEqual([50, 150, 250, 350, 450, 550, 650, 750, 850, 950]);
});

it('a ripple below the prominence is none, a spike of one sample is', () => {
  const rippled = Array.from(
    { length: 400 },
    (_, i) => 0.05 * (i % 2) + Math.min(i, 400 - i) / 200,
  );
  expect(turnsOf(rippled, 0.2)).toEqual([199]);
  expect(turnsOf(rippled.slice(150), 0.2)).toEqual([49]);
  const spiked = Array.from({ length: 400 }, (_, i) => (i === 123 ? 1 : 0));
  expect(turnsOf(spiked, 0.5)).toEqual([123]);
});
