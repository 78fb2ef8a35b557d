import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { keepSequence, keptSequence } from './sequence';

const kept = new Map<string, string>();

beforeEach(() => {
  kept.clear();
  vi.stubGlobal('sessionStorage', {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => kept.set(key, value),
    removeItem: (key: string) => kept.delete(key),
  });
});

afterEach(() => vi.unstubAllGlobals());

test('a sequence that has begun outlives a reload, until it has ended', () => {
  expect(keptSequence()).toBeNull();
  const sequence = { motions: ['s-1'], left: ['B'], ghosts: ['r-1'] };
  keepSequence(sequence);
  expect(keptSequence()).toEqual(sequence);
  keepSequence(null);
  expect(keptSequence()).toBeNull();
});

test('what has not begun, or is damaged, is no sequence', () => {
  keepSequence({ motions: [], left: ['A', 'B'], ghosts: [] });
  expect(keptSequence()).toBeNull();
  const [key] = [...kept.keys()];
  for (const text of ['{', '{"motions": "s-1"}', '{"motions": [1], "left": [], "ghosts": []}']) {
    kept.set(key ?? '', text);
    expect(keptSequence()).toBeNull();
  }
});
