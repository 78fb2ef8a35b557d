import { expect, it } from 'vitest';
import { matchingOptions, movedMark } from './finder';

const OPTIONS = [
  { value: 'A.x.thrust', name: 'Thrust A x', detail: 'N' },
  { value: 'B.x.thrust', name: 'Thrust B x', detail: 'N', group: 'machine' },
  { value: 'B.x.friction', name: 'Friction B x', title: 'LuGre friction of the guide' },
];

it('an option is found by words of its name, detail, title and group, in any order', () => {
  const values = (typed: string) => matchingOptions(OPTIONS, typed).map(({ value }) => value);
  expect(values('')).toEqual(OPTIONS.map(({ value }) => value));
  expect(values('b thrust')).toEqual(['B.x.thrust']);
  expect(values('LUGRE')).toEqual(['B.x.friction']);
  expect(values('machine')).toEqual(['B.x.thrust']);
  expect(values('thrust lugre')).toEqual([]);
});

it('the mark stays within the list', () => {
  expect(movedMark('ArrowDown', 1, 3)).toBe(2);
  expect(movedMark('PageDown', 1, 3)).toBe(2);
  expect(movedMark('ArrowUp', 0, 3)).toBe(0);
  expect(movedMark('a', 0, 3)).toBeNull();
});

it('puts whole words of a name first', () => {
  const options = ['Velocity x of B', 'Velocity y of B'].map((name) => ({ value: name, name }));
  expect(matchingOptions(options, 'velocity y of b')[0]?.name).toBe('Velocity y of B');
  expect(matchingOptions(options, 'velocity')[0]?.name).toBe('Velocity x of B');
});
