import { describe, expect, it } from 'vitest';
import {
  ageText,
  among,
  clean,
  clock,
  digits,
  parseNumber,
  percent,
  pretty,
  prettyUnit,
  scaleFor,
  scaleOf,
  inScale,
  quantity,
  spanText,
} from './units';

const text = (value: number | null, unit: string) => {
  const { number, unit: shown } = quantity(value, unit);
  return `${number} ${shown}`.trimEnd();
};

it.each([
  [20.5e-6, '20.5'],
  [0.251e-6, '0.251'],
  [44.9e-9, '0.045'],
  [0.3e-9, '<0.001'],
  [2.4e-17, '0'],
  [Number.NaN, '–'],
])('writes %s m in a column of µm as %s', (value, text) => {
  expect(among(value, { factor: 1e6, unit: 'µm' })).toBe(text);
});

it('writes texts of the server as people do', () => {
  expect(pretty('tau = p + s, sigma_1')).toBe('τ = p + s, σ_1');
  expect(pretty('[-14.2, 14.3] um')).toBe('[−14.2, 14.3] µm');
  expect(pretty('+-0.4 m/s^2, twice-differenced')).toBe('±0.4 m/s², twice-differenced');
});

describe('quantity', () => {
  it.each([
    [20.52e-6, 'm', '20.5 µm'],
    [0.015, 'm', '15.0 mm'],
    [-2.574e-6, 'm', '−2.57 µm'],
    [50e-9, 'm', '50.0 nm'],
    [200300, 'N/m', '200 kN/m'],
    [3.1915, 'A', '3.19 A'],
    [0.0314159, 'm/s', '31.4 mm/s'],
    [0.0658, 'm/s^2', '65.8 mm/s²'],
    [0, 'm', '0 m'],
    [0.5, '1', '0.500'],
    [999.7e-6, 'm', '1.00 mm'],
    [Number.NaN, 'm', '– m'],
  ])('writes %d %s as %s', (value, unit, expected) => {
    expect(text(value, unit)).toBe(expected);
  });
  it('writes a missing value as a dash', () => expect(text(null, 's')).toBe('– s'));
});

describe('digits', () => {
  it('keeps three significant digits', () => {
    expect([123.4, 12.34, 1.234, 0.1234, 1234].map((x) => digits(x))).toEqual([
      '123',
      '12.3',
      '1.23',
      '0.123',
      '1230',
    ]);
  });
  it('does not gain a digit by rounding', () => expect(digits(9.996)).toBe('10.0'));
});

it('chooses no prefix for units that cannot take one', () => {
  expect(scaleFor(1e-3, 'kg')).toEqual({ factor: 1, unit: 'kg' });
  expect(prettyUnit('1')).toBe('');
});

it('writes a share with its sign', () => {
  expect([-0.8746, 0, 18.1, 0.0449, null].map(percent)).toEqual([
    '−87.5 %',
    '0 %',
    '+1810 %',
    '+4.5 %',
    '–',
  ]);
});

it('writes a clock', () => {
  expect([0, 42.35, 61.0004, 59.9999].map(clock)).toEqual([
    '0:00.000',
    '0:42.350',
    '1:01.000',
    '1:00.000',
  ]);
});

describe('parseNumber', () => {
  it('reads what people type', () => {
    expect(['200.3', ' 1,5 ', '−2', '1e3', '.5'].map(parseNumber)).toEqual([
      200.3, 1.5, -2, 1000, 0.5,
    ]);
  });
  it('refuses what is no number', () => {
    expect(['', 'abc', '1e999', 'NaN', '1 2', '0x10'].map(parseNumber)).toEqual(
      new Array(6).fill(null),
    );
  });
});

it('cleans the noise of a change of unit', () => expect(clean(0.1 + 0.2)).toBe(0.3));

it('writes readings in a unit that they share', () => {
  const scale = scaleFor(20e-6, 'm');
  const values = [18.84e-6, -1.408e-6, 0.0421e-6, 0.0004e-6, 0, Number.NaN];
  expect(values.map((value) => inScale(value, scale))).toEqual([
    '18.8',
    '−1.41',
    '0.042',
    '0',
    '0',
    '–',
  ]);
});

it('takes the unit of values from those that are there', () => {
  const scale = scaleOf([Number.NaN, -16e-6, Number.NaN], 'm');
  expect(scale.unit).toBe('µm');
  expect([16e-6, Number.NaN].map((value) => inScale(value, scale))).toEqual(['16.0', '–']);
});

it('writes ages in words that can be read', () => {
  expect([0.4, 59, 90, 7300].map(ageText)).toEqual(['0 s', '59 s', '1 min', '2 h']);
});

it('writes no number where there is none', () => {
  const scale = { factor: 1e6, unit: 'µm' };
  for (const none of [Number.NaN, Infinity, null as unknown as number]) {
    expect([among(none, scale), inScale(none, scale), digits(none)]).toEqual(['–', '–', '–']);
  }
});

it('a short span has the decimals to tell its ends apart', () => {
  expect(spanText({ start: 4.5, end: 10.5 })).toBe('4.5 to 10.5 s');
  expect(spanText({ start: 0, end: 21.7349 })).toBe('0 to 21.73 s');
  expect(spanText({ start: 5.2505, end: 5.2515 })).toBe('5.2505 to 5.2515 s');
});
