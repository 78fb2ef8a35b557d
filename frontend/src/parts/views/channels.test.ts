import { expect, it } from 'vitest';
import { arranged } from './arranged';
import {
  errorChannels,
  firstPairs,
  knownPairs,
  ofVariant,
  pairSeries,
  pairsOf,
  present,
  quantityName,
  variantOf,
} from './channels';

const channels = (...names: string[]) => names.map((name) => ({ name, unit: 'm' }));
const LAB = channels(
  'x.position_reference',
  ...['A', 'B'].flatMap((variant) => [
    `${variant}.x.velocity`,
    `${variant}.x.friction`,
    `${variant}.x.following_error`,
  ]),
);

it('suggests channels that the source has', () => {
  expect(errorChannels(LAB, ['A', 'B'])).toEqual(['A.x.following_error', 'B.x.following_error']);
  expect(errorChannels(LAB, ['M'])).toEqual(['x.position_reference']);
  expect(errorChannels(channels('B.y.following_error'), ['B'])).toEqual(['B.y.following_error']);
  expect(firstPairs(LAB, ['A', 'B'])).toEqual([
    ['A.x.velocity', 'A.x.friction'],
    ['B.x.velocity', 'B.x.friction'],
  ]);
  expect(firstPairs(channels('u', 'v'), [])).toEqual([['u', 'v']]);
  expect(firstPairs(channels('u'), [])).toEqual([]);
  expect(knownPairs(LAB, ['A', 'B']).map(({ name }) => name)).toEqual([
    'Friction over velocity, x',
    'Error over position, x',
  ]);
});

it('keeps of a link the channels that the source has, and expressions', () => {
  const chosen = ['A.x.friction', 'C.x.friction', 'p=A.x.friction*A.x.velocity'];
  expect(present(chosen, LAB)).toEqual([chosen[0], chosen[2]]);
});

it('knows whose a pair is, and that of another variant', () => {
  expect(pairsOf(['a', 'b', 'c', 'd', 'e'])).toEqual([
    ['a', 'b'],
    ['c', 'd'],
  ]);
  expect(variantOf(['x.position_reference', 'B.x.following_error'])).toBe('B');
  expect(variantOf(['A.x.velocity', 'B.x.friction'])).toBe('');
  expect(ofVariant(['x.position_reference', 'B.x.thrust'], 'A')).toEqual([
    'x.position_reference',
    'A.x.thrust',
  ]);
  expect(quantityName('B.x.following_error')).toBe('Following error x');
});

it('draws B in its own colour, alone or beside A, and what is of none in a neutral one', () => {
  const values = LAB.map(({ name }) => ({ name, values: [1, 2, null] }));
  const samples = { period: 1, start: 0, columns: values };
  const inks = (...pairs: [string, string][]) =>
    pairSeries(pairs, samples).map(({ name, ink }) => [name, ink]);
  const of = (variant: string): [string, string] => [
    `${variant}.x.velocity`,
    `${variant}.x.friction`,
  ];
  expect(inks(of('B'))).toEqual([['B', 'b']]);
  expect(inks(of('A'), of('B'))).toEqual([
    ['A', 'a'],
    ['B', 'b'],
  ]);
  expect(inks(of('M'))).toEqual([['M', 'phase-a']]);
  expect(inks(['A.x.velocity', 'B.x.velocity'])[0]?.[1]).toBe('reference');
});

it('arranges as many plots as can be read', () => {
  expect(arranged(3, 370, 160).count).toBe(1);
  expect(arranged(3, 700, 300)).toEqual({ count: 2, columns: 2 });
  expect(arranged(3, 400, 600)).toEqual({ count: 3, columns: 1 });
  expect(arranged(3, 1500, 400)).toEqual({ count: 3, columns: 3 });
  expect(arranged(1, 0, 0)).toEqual({ count: 1, columns: 1 });
  expect(arranged(0, 500, 500).count).toBe(1);
});
