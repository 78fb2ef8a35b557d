import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { at } from './api/scenario-paths';
import type { Changes, Metrics, Scenario, SessionInfo } from './api/types';
import { Lab } from './store.svelte';

vi.hoisted(() => vi.stubGlobal('location', { href: 'http://127.0.0.1/' }));

const settled = () => new Promise((resolve) => setTimeout(resolve, 0));

function measured(end: number): Metrics {
  return { window: { start: 0, end }, variants: { A: {} }, comparison: {} } as unknown as Metrics;
}

/** A Lab whose session has run for a while, and what answers its questions for metrics. */
function playing(): { lab: Lab; answers: ((metrics: Metrics) => void)[] } {
  const lab = new Lab();
  lab.session.info = { id: 'a', time: 1 } as SessionInfo;
  const answers: ((metrics: Metrics) => void)[] = [];
  lab.api.metrics = vi.fn(() => new Promise<Metrics>((resolve) => answers.push(resolve)));
  return { lab, answers };
}

it('shows the metrics of the newest question, however late an older one is answered', async () => {
  const { lab, answers } = playing();
  lab.readMetrics();
  lab.readMetrics();
  lab.readMetrics();
  expect(answers).toHaveLength(1);
  answers[0]?.(measured(1));
  await settled();
  answers[1]?.(measured(2));
  await settled();
  expect(lab.metrics?.window.end).toBe(2);
  expect(answers).toHaveLength(2);
});

it('does not show the metrics of a session that it has left', async () => {
  const { lab, answers } = playing();
  lab.readMetrics();
  lab.session.info = { id: 'b', time: 1 } as SessionInfo;
  answers[0]?.(measured(1));
  await settled();
  expect(lab.metrics).toBeNull();
});

const K_P = 'variants.B.controller.x.k_p';
const K_D = 'variants.B.controller.x.k_d';
const SCENARIO = { variants: { B: { controller: { x: { k_p: 0, k_d: 0 } } } } };

/** A Lab in live mode on a session that keeps its changes as the server does. */
function changing(delay = 0): { lab: Lab; changes: Changes[] } {
  const lab = new Lab();
  lab.mode = 'live';
  const changes: Changes[] = [{ old: 1 }];
  const info = () =>
    ({
      id: 'a',
      revision: 0,
      scenario: SCENARIO,
      changes: changes.map((set) => ({ tick: 0, set, previous: {} })),
    }) as unknown as SessionInfo;
  const later = <T>(value: () => T) =>
    new Promise<T>((resolve) => setTimeout(() => resolve(value()), delay));
  lab.session.info = info();
  lab.session.missing = '';
  lab.session.base = {} as Scenario;
  lab.api.session = vi.fn(() => later(info));
  lab.api.patch = vi.fn((_id: string, set: Changes) =>
    later(() => {
      changes.push(set);
      return { tick: 0 };
    }),
  );
  lab.api.command = vi.fn(() =>
    later(() => {
      changes.pop();
      return info();
    }),
  ) as unknown as typeof lab.api.command;
  return { lab, changes };
}

describe('undo of live changes', () => {
  beforeEach(() => void vi.useFakeTimers());
  afterEach(() => void vi.useRealTimers());

  it('takes back the last gesture alone, though it began while one before was being sent', async () => {
    const { lab, changes } = changing(50);
    lab.set({ [K_P]: 1 }, true);
    await vi.advanceTimersByTimeAsync(10);
    lab.set({ [K_P]: 2 });
    lab.set({ [K_D]: 7 });
    await vi.advanceTimersByTimeAsync(1000);
    expect(changes).toEqual([{ old: 1 }, { [K_P]: 1 }, { [K_P]: 2 }, { [K_D]: 7 }]);
    await Promise.all([lab.undo(), vi.advanceTimersByTimeAsync(1000)]);
    expect(changes).toEqual([{ old: 1 }, { [K_P]: 1 }, { [K_P]: 2 }]);
    await Promise.all([lab.undo(), vi.advanceTimersByTimeAsync(1000)]);
    expect(changes).toEqual([{ old: 1 }]);
  });

  it('waits for a gesture that is still being sent, and leaves older changes alone', async () => {
    const { lab, changes } = changing(50);
    lab.set({ [K_P]: 1 });
    const undone = lab.undo();
    await vi.advanceTimersByTimeAsync(1000);
    await undone;
    expect(changes).toEqual([{ old: 1 }]);
    expect(lab.scenario).toEqual(SCENARIO);
  });

  it('does not take back what is set while it is at work', async () => {
    const { lab, changes } = changing(50);
    for (const k_p of [1, 2, 3]) {
      lab.set({ [K_P]: k_p }, k_p < 3);
      await vi.advanceTimersByTimeAsync(300);
    }
    const undone = lab.undo();
    await vi.advanceTimersByTimeAsync(60);
    lab.set({ [K_D]: 7 });
    await vi.advanceTimersByTimeAsync(1000);
    await undone;
    expect(changes).toEqual([{ old: 1 }, { [K_D]: 7 }]);
  });
});

it('shows the switches of the session in live mode, whoever turned them', () => {
  const lab = new Lab();
  lab.mode = 'live';
  const info = (compensation: boolean) =>
    ({ id: 'a', scenario: { variants: { B: { controller: { compensation } } } } }) as unknown;
  lab.session.info = info(false) as SessionInfo;
  const shown = () => at(lab.scenario, 'variants.B.controller.compensation');
  expect(shown()).toBe(false);
  lab.session.info = info(true) as SessionInfo;
  expect(shown()).toBe(true);
});
