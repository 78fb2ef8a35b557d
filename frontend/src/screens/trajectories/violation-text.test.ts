import { expect, it } from 'vitest';
import { withUnit } from './violation-text';

it('gives every acceleration in m/s²', () => {
  expect(withUnit(17.1, 'm/s^2')).toBe('17.1 m/s²');
  expect(withUnit(0.0658, 'm/s^2')).toBe('0.066 m/s²');
  expect(withUnit(0.199, 'm')).toBe('199 mm');
});
