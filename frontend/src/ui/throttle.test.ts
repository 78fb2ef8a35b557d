import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { Throttle } from './throttle.svelte';

beforeEach(() => {
  vi.useFakeTimers();
});

afterEach(() => {
  vi.useRealTimers();
});

it('takes the first change at once, and of those soon after it the newest alone', () => {
  const taken: number[] = [];
  const throttle = new Throttle<number>((value) => taken.push(value));
  throttle.offer(1);
  expect(taken).toEqual([1]);
  vi.advanceTimersByTime(40);
  const withdraw = throttle.offer(2);
  vi.advanceTimersByTime(40);
  withdraw();
  throttle.offer(3);
  expect(taken).toEqual([1]);
  vi.advanceTimersByTime(20);
  expect(taken).toEqual([1, 3]);
  vi.advanceTimersByTime(100);
  throttle.offer(4);
  expect(taken).toEqual([1, 3, 4]);
});
