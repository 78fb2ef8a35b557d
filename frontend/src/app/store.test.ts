import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { at } from './api/scenario-paths';
import type { Changes, Metrics, Scenario, SessionInfo } from './api/types';
import { Store } from './store.svelte';

vi.hoisted(() => vi.stubGlobal('location', { href: 'http://127.0.0.1/' }));

const settled = () => new Promise((resolve) => setTimeout(resolve, 0));

function measured(end: number): Metrics {
  return { window: { start: 0, end }, variants: { A: {} }, comparison: {} } as unknown as Metrics;
}

/** A Store whose session has run for a while, and what answers its questions for metrics. */
function playing(): { app: Store; answers: ((metrics: Metrics) => void)[] } {
  const app = new Store();
  app.session.info = { id: 'a', time: 1 } as SessionInfo;
  const answers: ((metrics: Metrics) => void)[] = [];
  app.api.metrics = vi.fn(() => new Promise<Metrics>((resolve) => answers.push(resolve)));
  return { app, answers };
}

it('shows the metrics of the newest question, however late an older one is answered', async () => {
  const { app, answers } = playing();
  app.metrics.read();
  app.metrics.read();
  app.metrics.read();
  expect(answers).toHaveLength(1);
  answers[0]?.(measured(1));
  await settled();
  answers[1]?.(measured(2));
  await settled();
  expect(app.metrics.current?.window.end).toBe(2);
  expect(answers).toHaveLength(2);
});

it('does not show the metrics of a session that it has left', async () => {
  const { app, answers } = playing();
  app.metrics.read();
  app.session.info = { id: 'b', time: 1 } as SessionInfo;
  answers[0]?.(measured(1));
  await settled();
  expect(app.metrics.current).toBeNull();
});

const K_P = 'variants.B.controller.x.k_p';
const K_D = 'variants.B.controller.x.k_d';
const SCENARIO = { variants: { B: { controller: { x: { k_p: 0, k_d: 0 } } } } };

/** A Store in live mode on a session that keeps its changes as the server does. */
function changing(delay = 0): { app: Store; changes: Changes[] } {
  const app = new Store();
  app.mode = 'live';
  const changes: Changes[] = [{ old: 1 }];
  const info = () =>
    ({
      id: 'a',
      revision: 0,
      scenario: SCENARIO,
      changes: changes.map((set) => ({ tick: 0, set, previous: {} })),
      events: [],
    }) as unknown as SessionInfo;
  const later = <T>(value: () => T) =>
    new Promise<T>((resolve) => setTimeout(() => resolve(value()), delay));
  app.session.info = info();
  app.session.missing = '';
  app.session.base = {} as Scenario;
  app.api.session = vi.fn(() => later(info));
  app.api.patch = vi.fn((_id: string, set: Changes) =>
    later(() => {
      changes.push(set);
      return { tick: 0 };
    }),
  );
  app.api.command = vi.fn(() =>
    later(() => {
      changes.pop();
      return info();
    }),
  ) as unknown as typeof app.api.command;
  return { app, changes };
}

describe('undo of live changes', () => {
  beforeEach(() => void vi.useFakeTimers());
  afterEach(() => void vi.useRealTimers());

  it('takes back the last gesture alone, though it began while one before was being sent', async () => {
    const { app, changes } = changing(50);
    app.set({ [K_P]: 1 }, true);
    await vi.advanceTimersByTimeAsync(10);
    app.set({ [K_P]: 2 });
    app.set({ [K_D]: 7 });
    await vi.advanceTimersByTimeAsync(1000);
    expect(changes).toEqual([{ old: 1 }, { [K_P]: 1 }, { [K_P]: 2 }, { [K_D]: 7 }]);
    await Promise.all([app.undo.run(), vi.advanceTimersByTimeAsync(1000)]);
    expect(changes).toEqual([{ old: 1 }, { [K_P]: 1 }, { [K_P]: 2 }]);
    await Promise.all([app.undo.run(), vi.advanceTimersByTimeAsync(1000)]);
    expect(changes).toEqual([{ old: 1 }]);
  });

  it('waits for a gesture that is still being sent, and leaves older changes alone', async () => {
    const { app, changes } = changing(50);
    app.set({ [K_P]: 1 });
    const undone = app.undo.run();
    await vi.advanceTimersByTimeAsync(1000);
    await undone;
    expect(changes).toEqual([{ old: 1 }]);
    expect(app.scenario).toEqual(SCENARIO);
  });

  it('does not take back what is set while it is at work', async () => {
    const { app, changes } = changing(50);
    for (const k_p of [1, 2, 3]) {
      app.set({ [K_P]: k_p }, k_p < 3);
      await vi.advanceTimersByTimeAsync(300);
    }
    const undone = app.undo.run();
    await vi.advanceTimersByTimeAsync(60);
    app.set({ [K_D]: 7 });
    await vi.advanceTimersByTimeAsync(1000);
    await undone;
    expect(changes).toEqual([{ old: 1 }, { [K_D]: 7 }]);
  });
});

it('shows the switches of the session in live mode, whoever turned them', () => {
  const app = new Store();
  app.mode = 'live';
  const info = (compensation: boolean) =>
    ({ id: 'a', scenario: { variants: { B: { controller: { compensation } } } } }) as unknown;
  app.session.info = info(false) as SessionInfo;
  const shown = () => at(app.scenario, 'variants.B.controller.compensation');
  expect(shown()).toBe(false);
  app.session.info = info(true) as SessionInfo;
  expect(shown()).toBe(true);
});

it('sends what is staged once, however often it is asked to meanwhile', async () => {
  const { app } = playing();
  type Giver = { give: (set: Changes) => Promise<void> };
  const give = vi.spyOn(app as unknown as Giver, 'give').mockResolvedValue();
  app.whatIfChanges.replace({ 'load.x': 1 });
  expect(await Promise.all([app.apply(), app.apply()])).toEqual([true, true]);
  expect(give).toHaveBeenCalledTimes(1);
});
