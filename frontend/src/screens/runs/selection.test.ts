import { expect, it } from 'vitest';
import { chosen, moved, neighbour, NOTHING, visible } from './selection';

const ORDER = ['a', 'b', 'c', 'd', 'e'];

it('a click selects one, Ctrl adds and takes away, Shift all up to it', () => {
  const one = chosen(NOTHING, ORDER, 'b', 'only');
  expect(one).toEqual({ ids: ['b'], at: 'b', anchor: 'b' });
  const range = chosen(one, ORDER, 'd', 'range');
  expect(range).toEqual({ ids: ['b', 'c', 'd'], at: 'd', anchor: 'b' });
  expect(chosen(range, ORDER, 'a', 'range').ids).toEqual(['a', 'b']);
  const two = chosen(one, ORDER, 'e', 'toggle');
  expect(two.ids).toEqual(['b', 'e']);
  expect(chosen(two, ORDER, 'b', 'toggle').ids).toEqual(['e']);
});

it('Shift without a beginning in the list selects one', () => {
  expect(chosen({ ids: ['x'], at: 'x', anchor: 'x' }, ORDER, 'c', 'range').ids).toEqual(['c']);
});

it('the keys stay within the list, and begin at its top', () => {
  expect(moved(ORDER, '', 1)).toBe('a');
  expect(moved(ORDER, 'a', -1)).toBe('a');
  expect(moved(ORDER, 'd', 10)).toBe('e');
  expect(moved([], 'd', 1)).toBe('');
});

it('after a deletion the next row takes over, or the one before', () => {
  expect(neighbour(ORDER, ['b', 'c'])).toBe('d');
  expect(neighbour(ORDER, ['d', 'e'])).toBe('c');
  expect(neighbour(['a'], ['a'])).toBe('');
});

it('only rows that can be seen are drawn, and a few beside them', () => {
  expect(visible({ top: 0, height: 530 }, 53, 100_000)).toEqual([0, 14]);
  expect(visible({ top: 53_000, height: 530 }, 53, 100_000)).toEqual([996, 1014]);
  expect(visible({ top: 0, height: 530 }, 53, 3)).toEqual([0, 3]);
});
