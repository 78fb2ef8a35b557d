import { expect, it } from 'vitest';
import { readOverlay, writeOverlay } from './overlay-address';

it('the address carries runs, their offsets and which are hidden', () => {
  const runs = [
    { id: 'r-a', offset: 0, shown: true },
    { id: 'r-b', offset: -1.25, shown: true },
    { id: 'r-c', offset: 0, shown: false },
  ];
  expect(writeOverlay(runs)).toBe('r-a,r-b:-1.25,r-c:0:hidden');
  expect(readOverlay(writeOverlay(runs))).toEqual(runs);
  expect(readOverlay('')).toEqual([]);
});

it('what is not understood is left out, as are runs named twice and a fifth', () => {
  const ids = (text: string) => readOverlay(text).map(({ id }) => id);
  expect(ids('r-a,r-a:2,<b>,,r-b')).toEqual(['r-a', 'r-b']);
  expect(ids('1,2,3,4,5')).toEqual(['1', '2', '3', '4']);
  expect(readOverlay('r-a:x')).toEqual([{ id: 'r-a', offset: 0, shown: true }]);
});
