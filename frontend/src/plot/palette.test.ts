import { expect, it } from 'vitest';
import { looksOf } from './palette';

it('a variant looks the same alone and among others', () => {
  expect(looksOf('A')).toEqual({ ink: 'a' });
  expect(looksOf('B')).toEqual({ ink: 'b', marker: 'dot' });
  expect(looksOf('E')).toEqual(looksOf('A'));
});

it('a measurement has no colour of a variant', () => {
  const inks = ['A', 'B'].map((name) => looksOf(name).ink);
  for (const name of ['M', 'force', 'E-Stop', 'B_field', 'AA'])
    expect(inks).not.toContain(looksOf(name).ink);
});
