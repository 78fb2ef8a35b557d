import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { Pace } from './throttle';

beforeEach(() => {
  vi.useFakeTimers();
});

afterEach(() => {
  vi.useRealTimers();
});

it('takes the first change at once, and of those soon after it the newest alone', () => {
  const taken: number[] = [];
  const pace = new Pace<number>((value) => taken.push(value));
  pace.offer(1);
  expect(taken).toEqual([1]);
  vi.advanceTimersByTime(40);
  const withdraw = pace.offer(2);
  vi.advanceTimersByTime(40);
  withdraw();
  pace.offer(3);
  expect(taken).toEqual([1]);
  vi.advanceTimersByTime(20);
  expect(taken).toEqual([1, 3]);
  vi.advanceTimersByTime(100);
  pace.offer(4);
  expect(taken).toEqual([1, 3, 4]);
});
