import { expect, it } from 'vitest';
import {
  hasTerm,
  termsOf,
  toggled,
  viewOf,
  viewsAt,
  withView,
  type QuickView,
} from './search-text';

const NOW = Date.UTC(2026, 10, 20, 12);
const VIEWS = viewsAt(NOW);
const view = (id: string) => VIEWS.find((each) => each.id === id) as QuickView;

it('quotes keep blanks together', () => {
  expect(termsOf(`tag:rig "scenario:my own" 'a b' B.x.max<3um`)).toEqual([
    'tag:rig',
    'scenario:my own',
    'a b',
    'B.x.max<3um',
  ]);
  expect(hasTerm('"scenario:my own"', 'scenario:my own')).toBe(true);
});

it('a filter adds its term, and takes it away again', () => {
  expect(toggled('', 'tag:rig')).toBe('tag:rig');
  expect(toggled('glitch', 'scenario:my own')).toBe('glitch "scenario:my own"');
  expect(toggled('glitch "scenario:my own" tag:a', 'scenario:my own')).toBe('glitch tag:a');
});

it('a view takes the place of another one and leaves the other terms', () => {
  expect(withView('is:pinned tag:rig', view('week'), VIEWS)).toBe('after:2026-11-13 tag:rig');
  expect(withView('tag:rig is:deleted', view('all'), VIEWS)).toBe('tag:rig');
  expect(viewOf('tag:rig state:partial', VIEWS)).toBe('partial');
  expect(viewOf('tag:rig', VIEWS)).toBe('all');
});
