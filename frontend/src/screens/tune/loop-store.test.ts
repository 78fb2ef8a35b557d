import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import type { Api } from '../../app/api/client';
import type { Scenario } from '../../app/api/types';
import { LoopStore } from './loop-store.svelte';

const QUESTION = {
  scenario: {} as Scenario,
  set: {},
  variant: 'B',
  axis: 'x' as const,
  chosen: {},
};

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

it('says that it asks until there is an answer, and keeps the reason of a refusal', async () => {
  let busy = true;
  const answer = (value: object) => () =>
    busy ? Promise.reject(new Error('2 simulations run already')) : Promise.resolve(value);
  const loops = new LoopStore({
    response: answer({}),
    accuracy: answer({}),
    loop: answer({ variants: {} }),
  } as unknown as Api);

  loops.ask(QUESTION);
  expect(loops.asking).toBe(true);
  await vi.runAllTimersAsync();
  expect(loops.asking).toBe(false);
  expect(loops.problem).toBe('2 simulations run already');

  busy = false;
  loops.again();
  expect(loops.asking).toBe(true);
  await vi.runAllTimersAsync();
  expect([loops.asking, loops.problem, loops.present === null]).toEqual([false, '', false]);
});
