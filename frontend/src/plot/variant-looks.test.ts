import { expect, it } from 'vitest';
import { looksOf } from './variant-looks';

it('a variant looks the same alone and among others', () => {
  expect(looksOf('A')).toEqual({ ink: 'a' });
  expect(looksOf('B')).toEqual({ ink: 'b', marker: 'dot' });
  expect(looksOf('E')).toEqual(looksOf('A'));
});
