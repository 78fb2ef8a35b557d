import { afterEach, beforeEach, expect, it, vi } from 'vitest';

vi.hoisted(() => vi.stubGlobal('location', new URL('http://lab/'))); // before the modules read it
import { takeLook } from './lab-look';
import { view } from './scopes/view.svelte';

const address = (look: string) => {
  vi.stubGlobal('location', new URL(`http://lab/?look=${encodeURIComponent(look)}`));
  vi.stubGlobal('history', { replaceState: vi.fn() });
};
const seen = () => [view.zoom, view.cursors, view.statistic, view.span, view.variant, view.axis];

beforeEach(() => {
  view.zoom = null;
  view.cursors = [];
});
afterEach(() => vi.unstubAllGlobals());

it('takes what an address says', () => {
  address('{"zoom":[1,2],"cursors":[1.5],"span":5,"of":["A","y"]}');
  takeLook();
  expect(view.zoom).toEqual({ from: 1, to: 2 });
  expect(view.cursors).toEqual([1.5]);
  expect([view.span, view.variant, view.axis]).toEqual([5, 'A', 'y']);
});

it.each(['null', '5', '"text"', '[1]', '[]', 'true', '', '{not', '{"zoom":null,"cursors":{}}'])(
  'leaves %s out',
  (look) => {
    const before = seen();
    address(look);
    takeLook();
    expect(seen()).toEqual(before);
  },
);
