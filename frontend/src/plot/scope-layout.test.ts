import { describe, expect, it } from 'vitest';
import { layoutText, moved, readLayout, resized, scopeWith } from './scope-layout';

describe('a layout as text', () => {
  it('is read as it was written', () => {
    const scopes = [
      scopeWith('A.x.following_error', 'B.x.following_error'),
      {
        channels: ['B.x.thrust', 'B.x.friction', 'odd name, with ; signs!~@='],
        hidden: ['B.x.friction'],
        own: ['B.x.thrust', 'B.x.friction'],
        size: 2.5,
        hold: [-1e-5, 2.5e-6] as const,
      },
    ];
    expect(readLayout(layoutText(scopes))).toEqual(scopes);
  });
  it('is short where nothing is unusual', () => {
    expect(layoutText([scopeWith('A.x.thrust', 'B.x.thrust'), scopeWith('x.load_force')])).toBe(
      'A.x.thrust,B.x.thrust;x.load_force',
    );
  });
  it('is refused where it is none', () => {
    const many = Array.from({ length: 17 }, (_, i) => `A.x.c${i}`).join();
    for (const text of ['', ';', 'a,,b', 'a b', 'a@x', '%E0%A4', many, 'a;'.repeat(13) + 'a']) {
      expect([text, readLayout(text)]).toEqual([text, null]);
    }
  });
  it('keeps sizes within reason and drops ends that are none', () => {
    const [scope] = readLayout('a,a@1000=2:1') ?? [];
    expect(scope).toMatchObject({ channels: ['a'], size: 8, hold: null });
    expect(readLayout('a=-1e999:1e999')?.[0]?.hold).toBeNull();
  });
});

it('scopes change places', () => {
  expect(moved(['a', 'b', 'c'], 0, 2)).toEqual(['b', 'c', 'a']);
  expect(moved(['a', 'b'], 0, 2)).toEqual(['a', 'b']);
});

it('a line between two moves within both', () => {
  expect(resized(1, 1, 0.25)).toEqual([1.5, 0.5]);
  expect(resized(1, 1, -9)).toEqual([0.25, 1.75]);
});
