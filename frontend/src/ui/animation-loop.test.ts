import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { loop } from './animation-loop';

/** Whatever the page listens to, by name; and what it observes. */
const heard = new Map<string, () => void>();
let rebuilt = (): void => {};
let drawn: number[] = [];
let remove = (): void => {};

class Observer {
  constructor(callback: () => void) {
    rebuilt = callback;
  }
  observe(): void {}
}

beforeEach(() => {
  vi.useFakeTimers({ toFake: ['setTimeout', 'clearTimeout', 'performance'] });
  vi.stubGlobal('requestAnimationFrame', (draw: (now: number) => void) =>
    setTimeout(() => draw(performance.now()), 16),
  );
  vi.stubGlobal('addEventListener', (name: string, callback: () => void) =>
    heard.set(name, callback),
  );
  vi.stubGlobal('MutationObserver', Observer);
  vi.stubGlobal('document', {});
  drawn = [];
  remove = loop.add((now) => drawn.push(now));
});

afterEach(() => {
  remove();
  vi.advanceTimersByTime(1000);
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

describe('the animation loop', () => {
  it('draws every frame while something moves, and looks ten times a second at rest', () => {
    vi.advanceTimersByTime(300);
    expect(drawn.length).toBeGreaterThan(15);
    vi.advanceTimersByTime(200);
    drawn = [];
    vi.advanceTimersByTime(2000);
    expect(drawn.length).toBeGreaterThan(15);
    expect(drawn.length).toBeLessThan(21);
  });

  it('draws in the next frame after a hand or a rebuilt page, and goes on', () => {
    for (const wake of [heard.get('pointermove'), heard.get('keydown'), rebuilt, loop.stir]) {
      vi.advanceTimersByTime(1030);
      drawn = [];
      wake?.();
      vi.advanceTimersByTime(17);
      expect(drawn).toHaveLength(1);
      vi.advanceTimersByTime(200);
      expect(drawn.length).toBeGreaterThan(10);
    }
  });

  it('stops with the last thing that draws', () => {
    remove();
    vi.advanceTimersByTime(1000);
    drawn = [];
    loop.stir();
    vi.advanceTimersByTime(1000);
    expect(drawn).toEqual([]);
  });
});
