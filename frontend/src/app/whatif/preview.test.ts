import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { StillSource } from '../../plot/source';
import { readAnswer } from '../api/curves-answer';
import { ApiError, type Api } from '../api/client';
import type { Scenario } from '../api/types';
import { Obstacle, type PageKernel } from './page-kernel';
import { Refused } from './refused-changes';
import { WhatIf } from './whatif.svelte';

vi.mock('../api/curves-answer', () => ({ readAnswer: vi.fn() }));

type Preview = ReturnType<typeof readAnswer>;
const preview = (begin: number): Preview => {
  return { begin, source: new StillSource(0, 1, 0, new Map()) } as unknown as Preview;
};
const question = (k_p: number) => ({ scenario: {} as Scenario, set: { k_p }, columns: [] });
const later = <T>(ms: number, value: T) =>
  new Promise<T>((resolve) => setTimeout(() => resolve(value), ms));

/** A what-if whose page answers with `begin` = k_p, and whose server answers with -k_p. */
function whatIfOf(run: (k_p: number) => Promise<Preview>, serverTakes = 20) {
  const requests: boolean[] = [];
  const api = {
    whatif: vi.fn(({ set, exact }: { set: { k_p: number }; exact: boolean }) => {
      requests.push(exact);
      return later(serverTakes, set.k_p);
    }),
  };
  vi.mocked(readAnswer).mockImplementation((k_p) => preview(-(k_p as unknown as number)));
  const kernel = {
    run: vi.fn((_: unknown, { set }: { set: { k_p: number } }) => run(set.k_p)),
    curves: vi.fn(() => Promise.resolve(preview(0).source)),
  };
  const refused = vi.fn();
  const whatif = new WhatIf(api as unknown as Api, refused, kernel as unknown as PageKernel);
  return { whatif, requests, refused, kernel, api };
}

const begin = (whatif: WhatIf) => whatif.answer?.begin;

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

it('the page previews what the server then computes exactly', async () => {
  const { whatif, requests } = whatIfOf((k_p) => later(10, preview(k_p)));
  for (const k_p of [1, 2, 3]) {
    whatif.ask(question(k_p));
    await vi.advanceTimersByTimeAsync(16);
    expect([begin(whatif), whatif.standing, whatif.computer]).toEqual([k_p, 'preview', 'page']);
  }
  expect(requests).toEqual([]);
  await vi.advanceTimersByTimeAsync(1000);
  expect([begin(whatif), whatif.standing]).toEqual([-3, 'exact']);
  expect(requests).toEqual([true]);
});

it('an exact result that comes while the hand moves again is too late', async () => {
  const { whatif } = whatIfOf((k_p) => later(10, preview(k_p)), 100);
  whatif.ask(question(1));
  await vi.advanceTimersByTimeAsync(250);
  whatif.ask(question(2));
  await vi.advanceTimersByTimeAsync(20);
  expect(begin(whatif)).toBe(2);
  await vi.advanceTimersByTimeAsync(100);
  expect([begin(whatif), whatif.standing]).toEqual([2, 'preview']);
});

it('a refusal that comes after a newer question does not cost its answer', async () => {
  const { whatif, api } = whatIfOf((k_p) => later(500, preview(k_p)));
  api.whatif.mockImplementationOnce(async () => {
    await later(100, null);
    throw new ApiError({ title: '', status: 422, detail: 'no', errors: [] }, null);
  });
  whatif.ask(question(1));
  await vi.advanceTimersByTimeAsync(250);
  whatif.ask(question(2));
  await vi.advanceTimersByTimeAsync(1000);
  expect([begin(whatif), whatif.standing]).toEqual([-2, 'exact']);
});

it('a preview slower than the exact result is too late', async () => {
  const { whatif } = whatIfOf((k_p) => later(500, preview(k_p)));
  whatif.ask(question(1));
  await vi.advanceTimersByTimeAsync(1000);
  expect([begin(whatif), whatif.standing]).toEqual([-1, 'exact']);
});

it.each([new Obstacle('no SIMD'), new TypeError('no SIMD')])(
  'the server previews after %s',
  async (error) => {
    const { whatif, requests } = whatIfOf(() => Promise.reject(error));
    whatif.ask(question(1));
    await vi.advanceTimersByTimeAsync(30);
    expect([begin(whatif), whatif.computer, whatif.obstacle]).toEqual([-1, 'server', 'no SIMD']);
    await vi.advanceTimersByTimeAsync(1000);
    expect([requests, whatif.standing]).toEqual([[false, true], 'exact']);
  },
);

it('a refused change keeps the curves and asks for no exact result', async () => {
  const problem = { title: '', status: 422, detail: 'out of range', errors: [] };
  const { whatif, requests, refused } = whatIfOf((k_p) =>
    k_p < 0 ? Promise.reject(new ApiError(problem, null)) : later(10, preview(k_p)),
  );
  whatif.ask(question(1));
  await vi.advanceTimersByTimeAsync(20);
  whatif.ask(question(-1));
  await vi.advanceTimersByTimeAsync(1000);
  expect([begin(whatif), whatif.standing, whatif.reason]).toEqual([1, 'failed', 'out of range']);
  expect(refused).toHaveBeenLastCalledWith([], 'out of range');
  expect(requests).toEqual([]);
});

it('the server is asked about what the page alone refuses', async () => {
  const { whatif, requests, refused } = whatIfOf(() =>
    Promise.reject(new Refused([{ loc: 'k_p', message: 'is out of range' }])),
  );
  whatif.ask(question(2));
  await vi.advanceTimersByTimeAsync(20);
  expect([whatif.standing, requests]).toEqual(['failed', []]);
  expect(refused.mock.lastCall?.[0]).toMatchObject([{ loc: 'k_p' }]);
  await vi.advanceTimersByTimeAsync(1000);
  expect([begin(whatif), whatif.standing, requests]).toEqual([-2, 'exact', [true]]);
  expect(refused).toHaveBeenLastCalledWith([], '');
});

it('a stretch looked at during a preview is drawn from the samples in the page', async () => {
  const { whatif, kernel, requests } = whatIfOf((k_p) => later(10, preview(k_p)));
  whatif.ask(question(1));
  await vi.advanceTimersByTimeAsync(20);
  const before = whatif.answer?.source;
  whatif.look({ from: 1, to: 2 });
  await vi.advanceTimersByTimeAsync(1);
  expect(kernel.curves).toHaveBeenCalled();
  expect(whatif.answer?.source).not.toBe(before);
  await whatif.samples(['x'], { from: 1, to: 2 });
  expect(requests).toEqual([]);
});
