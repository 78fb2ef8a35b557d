import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { StillSource } from '../../plot/source';
import { ApiError, UNREACHABLE, type Api } from '../api/client';
import type { Scenario } from '../api/types';
import { readAnswer } from '../api/curves-answer';
import { noteTransfer } from '../line-rate';
import { WhatIf } from './whatif.svelte';

vi.mock('../api/curves-answer', () => ({ readAnswer: vi.fn() }));

const problem = (status: number) => ({ title: '', status, detail: `status ${status}`, errors: [] });
const refusal = (status: number, retryAfter: number | null = null) =>
  new ApiError(problem(status), retryAfter);

const question = (k_p: number) => ({
  scenario: {} as Scenario,
  set: { k_p },
  columns: [],
});

/** A what-if whose server answers each request with the next of some outcomes, then soundly. */
function answering(...outcomes: ApiError[]) {
  const requests: [unknown, number][] = [];
  const api = {
    whatif: vi.fn(({ set, points }: { set: { k_p: number }; points: number }) => {
      requests.push([set.k_p, points]);
      const outcome = outcomes.shift();
      return outcome ? Promise.reject(outcome) : Promise.resolve(new ArrayBuffer(0));
    }),
  };
  const refused = vi.fn();
  return { whatif: new WhatIf(api as unknown as Api, refused), requests, refused };
}

beforeEach(() => {
  vi.useFakeTimers();
  vi.mocked(readAnswer).mockReturnValue({ source: { last: 0 } } as ReturnType<typeof readAnswer>);
});
afterEach(() => void vi.useRealTimers());

describe('a what-if that the server has no room for', () => {
  it.each([429, 503, UNREACHABLE])('is asked again after %i', async (status) => {
    const { whatif, requests, refused } = answering(
      refusal(status),
      refusal(status),
      refusal(status),
    );
    whatif.ask(question(1));
    await vi.advanceTimersByTimeAsync(10);
    expect(whatif.standing).toBe('retrying');
    expect(whatif.reason).toBe(`status ${status}`);
    await vi.advanceTimersByTimeAsync(10_000);
    expect(whatif.standing).toBe('exact');
    expect(requests.at(-1)).toEqual([1, 20_000]);
    expect(refused).not.toHaveBeenCalledWith([], expect.stringContaining('status'));
  });

  it('is asked again when the server says', async () => {
    const { whatif, requests } = answering(refusal(429), refusal(429, 7000));
    whatif.ask(question(1));
    await vi.advanceTimersByTimeAsync(1000);
    expect(requests.length).toBe(2);
    await vi.advanceTimersByTimeAsync(5900);
    expect(requests.length).toBe(2);
    await vi.advanceTimersByTimeAsync(500);
    expect(requests.length).toBe(3);
    expect(whatif.standing).toBe('exact');
  });

  it('is not asked again once there is a newer one', async () => {
    const { whatif, requests } = answering(refusal(429, 1000));
    whatif.ask(question(1));
    await vi.advanceTimersByTimeAsync(10);
    whatif.ask(question(2));
    await vi.advanceTimersByTimeAsync(10_000);
    expect(requests.map(([k_p]) => k_p)).toEqual([1, 2, 2]);
    expect(whatif.standing).toBe('exact');
  });
});

it('a stretch that was looked at is not asked for again', async () => {
  const [duration, period] = [240, 5e-4];
  const { whatif, requests } = answering();
  const answered = (start: number, end: number, bins: number) => {
    const source = new StillSource(start, (end - start) / bins, bins, new Map());
    const answer = { source, duration, period } as ReturnType<typeof readAnswer>;
    vi.mocked(readAnswer).mockReturnValue(answer);
    return source;
  };
  const whole = answered(0, duration, 20_000);
  whatif.ask(question(1));
  await vi.advanceTimersByTimeAsync(1000);
  const [close, far] = [
    { from: 100, to: 102 },
    { from: 0, to: 240 },
  ];
  expect(whatif.over(close)).toBe(whole);
  const part = answered(99, 103, 8000);
  whatif.look(close);
  await vi.advanceTimersByTimeAsync(10);
  expect(whatif.over(close)).toBe(part);
  expect(requests.length).toBe(3);
  whatif.look(far);
  expect(whatif.over(far)).toBe(whole);
  whatif.look(close);
  await vi.advanceTimersByTimeAsync(10);
  expect(whatif.over(close)).toBe(part);
  expect(requests.length).toBe(3);
});

it('a question does not wait for the answer to an older one that is long on its way', async () => {
  const sent: [number, AbortSignal][] = [];
  const api = {
    whatif: vi.fn(({ set }: { set: { k_p: number } }, signal: AbortSignal) => {
      sent.push([set.k_p, signal]);
      if (set.k_p > 1) return Promise.resolve(new ArrayBuffer(0));
      return new Promise((_, reject) => {
        signal.addEventListener('abort', () => reject(refusal(UNREACHABLE)));
      });
    }),
  };
  const whatif = new WhatIf(api as unknown as Api, vi.fn());
  whatif.ask(question(1));
  await vi.advanceTimersByTimeAsync(900);
  expect(sent[0]?.[1].aborted).toBe(false);
  await vi.advanceTimersByTimeAsync(2000);
  whatif.ask(question(2));
  expect(sent[0]?.[1].aborted).toBe(true);
  await vi.advanceTimersByTimeAsync(1000);
  expect(sent.map(([k_p]) => k_p)).toEqual([1, 2, 2]);
  expect(whatif.standing).toBe('exact');
});

it('over a slow line the curves of the exact result are coarser', async () => {
  const { whatif, requests } = answering();
  const pointsAfter = async (name: string, bytes: number) => {
    noteTransfer(`http://lab${name}`, bytes, 1000);
    whatif.ask({ ...question(1), columns: Array<string>(20).fill('A.x.thrust') });
    await vi.advanceTimersByTimeAsync(1000);
    return requests.at(-1)?.[1];
  };
  expect(await pointsAfter('/assets/index.js', 80_000)).toBe(1000);
  expect(await pointsAfter('/api/v1/whatif', 20_000)).toBe(250);
  // Neither what waits for something nor what is too short says how fast the line is.
  expect(await pointsAfter('/api/v1/jobs', 80_000)).toBe(250);
  expect(await pointsAfter('/api/v1/whatif', 5000)).toBe(250);
  expect(await pointsAfter('/api/v1/whatif', 50_000_000)).toBe(20_000);
});

it('a what-if that is refused is not asked again', async () => {
  const { whatif, requests, refused } = answering(refusal(422));
  whatif.ask(question(1));
  await vi.advanceTimersByTimeAsync(10_000);
  expect([whatif.standing, whatif.reason]).toEqual(['failed', 'status 422']);
  expect(requests.length).toBe(1);
  expect(refused).toHaveBeenLastCalledWith([], 'status 422');
});
