import { expect, it, vi } from 'vitest';
import { LatestWins } from './latest-wins';

it('runs one at a time and skips to the newest', async () => {
  const seen: number[] = [];
  const done: (() => void)[] = [];
  const newest = new LatestWins<number>((value) => {
    seen.push(value);
    return new Promise((resolve) => done.push(resolve));
  });
  [1, 2, 3].forEach((value) => newest.push(value));
  expect(seen).toEqual([1]);
  expect(newest.superseded).toBe(true);
  done[0]?.();
  await vi.waitFor(() => expect(seen).toEqual([1, 3]));
  expect(newest.superseded).toBe(false);
  done[1]?.();
  await vi.waitFor(() => expect(newest.busy).toBe(false));
  newest.push(4);
  expect(seen).toEqual([1, 3, 4]);
});

it('goes on after a job that throws', async () => {
  const errors = vi.spyOn(console, 'error').mockImplementation(() => undefined);
  const seen: number[] = [];
  const newest = new LatestWins<number>((value) => {
    seen.push(value);
    return value === 1 ? Promise.reject(new Error('no')) : Promise.resolve();
  });
  newest.push(1);
  newest.push(2);
  await vi.waitFor(() => expect(seen).toEqual([1, 2]));
  errors.mockRestore();
});
