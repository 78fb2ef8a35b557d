import { afterEach, describe, expect, it, vi } from 'vitest';
import { load } from './storage';

function keep(text: string): void {
  vi.stubGlobal('localStorage', { getItem: () => text });
}

afterEach(() => vi.unstubAllGlobals());

describe('load', () => {
  it('returns what was kept', () => {
    keep('{"x":"3","y":"4"}');
    expect(load('push', { x: '2', y: '2' })).toEqual({ x: '3', y: '4' });
    keep('{"anything":1}');
    expect(load('draft', {})).toEqual({ anything: 1 });
    expect(load('session', null)).toEqual({ anything: 1 });
  });

  it.each(['', '{not', 'null', '5', '[1]', '"text"', '{"x":5,"y":"1"}', '{"x":"1"}'])(
    'returns the fallback where %s was kept',
    (text) => {
      keep(text);
      expect(load('push', { x: '2', y: '2' })).toEqual({ x: '2', y: '2' });
    },
  );
});
