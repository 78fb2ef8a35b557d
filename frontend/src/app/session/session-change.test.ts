import { afterEach, describe, expect, it, vi } from 'vitest';
import type { Changes, Scenario, RunEvent, SessionInfo } from '../api/types';
import { messages } from '../messages.svelte';
import { Store } from '../store.svelte';

vi.hoisted(() => {
  vi.stubGlobal('location', { href: 'http://127.0.0.1/', protocol: 'http:', host: '127.0.0.1' });
  vi.stubGlobal('history', { replaceState: () => undefined });
  vi.stubGlobal(
    'WebSocket',
    class {
      close() {}
    },
  );
});

const settled = () => new Promise((resolve) => setTimeout(resolve, 0));

const K_P = 'variants.B.controller.x.k_p';

function scenario(name: string, k_p = 200300): Scenario {
  return { name, variants: { B: { controller: { x: { k_p } } } } } as unknown as Scenario;
}

/** A Store on a server of its own, with a session of the circle that had a gain changed. */
function tuned(): { app: Store; made: { scenario: unknown; set: Changes }[]; commands: string[] } {
  const app = new Store();
  const made: { scenario: unknown; set: Changes }[] = [];
  const commands: string[] = [];
  const info = (of: Scenario, base = of) =>
    ({
      id: `s${made.length}`,
      state: 'paused',
      time: 0,
      speed: 1,
      changes: [],
      events: [],
      stream: '',
      base,
      scenario: of,
      revision: made.length,
    }) as unknown as SessionInfo;
  const { api, session } = app;
  api.create = vi.fn(async ({ scenario: of = 'circle', set = {} }) => {
    made.push({ scenario: of, set });
    return info(typeof of === 'string' ? scenario(of) : of);
  });
  api.session = vi.fn(async () => ({ ...session.info, watchers: 1 }) as SessionInfo);
  api.scenario = vi.fn(async (name: string) => scenario(name));
  api.patch = vi.fn(async () => ({ tick: 0 }));
  api.remove = vi.fn();
  api.command = vi.fn(async (_: string, name: string) => {
    commands.push(name);
    return { ...session.info, state: name === 'play' ? 'playing' : 'paused' } as SessionInfo;
  }) as unknown as typeof api.command;
  session.info = info(scenario('circle', 619000), scenario('circle'));
  session.base = scenario('circle');
  session.missing = '';
  return { app, made, commands };
}

const notice = () => messages.list.at(-1);

afterEach(() => {
  for (const { id } of messages.list) messages.dismiss(id);
});

describe('another scenario', () => {
  it('says what stays behind, and Undo brings it back', async () => {
    const { app, made } = tuned();
    app.setMode('whatif');
    app.set({ [K_P]: 700000 });
    await app.loadScenario('rhombus');
    expect(app.draft).toEqual({});
    expect(notice()?.text).toMatch(/^circle was left with one change: B kp x/);
    expect(notice()?.actions.map(({ name }) => name)).toEqual(['Undo', 'Keep the gains']);
    expect(app.undo.possible).toBe(true);
    await app.undo.run();
    expect(made.at(-1)?.scenario).toEqual(scenario('circle', 619000));
    expect(app.draft).toEqual({ [K_P]: 700000 });
    expect(app.changes).toMatchObject([{ path: K_P, from: 200300, to: 700000 }]);
    expect(app.undo.goesBack).toBe(false);
  });

  it('can be gone back from after others, and leaves its gains to the one that is open', async () => {
    const { app, made } = tuned();
    app.setMode('whatif');
    app.set({ [K_P]: 700000 });
    await app.loadScenario('rhombus');
    const [undo, keep] = notice()?.actions ?? [];
    await app.loadScenario('pentagram');
    expect(app.undo.text).toBe('Go back to the session before, circle, at 0 s');
    keep?.run();
    expect(app.draft).toEqual({ [K_P]: 700000 });
    undo?.run();
    await settled();
    expect(made.at(-1)?.scenario).toEqual(scenario('circle', 619000));
    expect(app.draft).toEqual({ [K_P]: 700000 });
    await app.undo.run();
    expect(app.draft).toEqual({});
    undo?.run(); // done already
    await settled();
    expect(made).toHaveLength(3);
  });

  it('takes the gains along as what-if changes', async () => {
    const { app } = tuned();
    await app.loadScenario('rhombus');
    notice()?.actions[1]?.run();
    expect(app.mode).toBe('whatif');
    expect(app.draft).toEqual({ [K_P]: 619000 });
  });

  it('says nothing where nothing stays behind, and starts at real time', async () => {
    const { app } = tuned();
    await app.loadScenario('rhombus');
    for (const { id } of messages.list) messages.dismiss(id);
    app.session.speed = 10;
    await app.loadScenario('circle');
    expect(notice()).toBeUndefined();
    expect(app.session.speed).toBe(1);
  });
});

it('makes what was applied a what-if change again', async () => {
  const { app, commands } = tuned();
  const { session } = app;
  app.setMode('whatif');
  app.set({ [K_P]: 700000 });
  await app.apply();
  expect(app.draft).toEqual({});
  session.info = {
    ...session.info,
    changes: [{ tick: 0, set: { [K_P]: 700000 }, previous: { [K_P]: 619000 } }],
  } as unknown as SessionInfo;
  app.setMode('live');
  expect(app.undo.text).toBe('Take back what was sent to the motor: B kp x');
  await app.undo.run();
  expect(commands).toEqual(['undo']);
  expect(app.draft).toEqual({ [K_P]: 700000 });
  app.setMode('whatif');
  session.info = { ...session.info, changes: [] } as unknown as SessionInfo;
  expect(app.undo.text).toBe('Take back the staged change of B kp x');
  await app.undo.run();
  expect(app.draft).toEqual({});
});

it('goes back from a given path while what-if changes wait', async () => {
  const { app, made } = tuned();
  app.setMode('whatif');
  app.set({ [K_P]: 700000 });
  await app.givePath({ name: '', table: { kind: 'path' } });
  expect(app.undo.goesBack).toBe(true);
  await app.undo.run();
  expect(made).toHaveLength(2);
  expect(app.draft).toEqual({ [K_P]: 700000 });
});

it('gives a path with all gains, what-if changes and the speed, and a way back', async () => {
  const { app, made } = tuned();
  app.setMode('whatif');
  app.set({ [K_P]: 700000, 'trajectory.radius': 0.02 });
  app.session.speed = 4;
  await app.givePath({ name: 'my-star', table: { kind: 'path' } });
  expect(made.at(-1)).toEqual({
    scenario: scenario('circle', 619000),
    set: { trajectory: { kind: 'path' } },
  });
  expect(app.draft).toEqual({ [K_P]: 700000 });
  expect(app.session.speed).toBe(4);
  expect(notice()?.text).toBe('The session took my-star and went back to 0 s.');
  notice()?.actions[0]?.run();
  await settled();
  expect(app.draft).toEqual({ [K_P]: 700000, 'trajectory.radius': 0.02 });
});

it('remembers when a change was made and undone, until a reset', async () => {
  const { app } = tuned();
  const { session, api } = app;
  session.moments.period = 0.0005;
  const now = (info: Partial<SessionInfo>) => {
    api.command = vi.fn(async () => ({ ...session.info, ...info }) as SessionInfo);
  };
  const facts = { kind: 'change', by: '', set: {} };
  const [change, undo]: [RunEvent, RunEvent] = [
    { ...facts, tick: 2000, undo: false },
    { ...facts, tick: 5000, undo: true },
  ] as [RunEvent, RunEvent];
  now({ tick: 3000, changes: [{ tick: 2000, set: {}, previous: {} }], events: [change] });
  await session.step(1);
  now({ tick: 5000, changes: [], events: [change, undo] });
  await session.undo();
  expect(session.moments.changes.map(({ time }) => time)).toEqual([1, 2.5]);
  now({ tick: 0, timeline: 1, events: [] });
  await session.reset();
  expect(session.moments.changes).toEqual([]);
});

describe('play', () => {
  it('gives what-if changes to the session first, or leaves them out', async () => {
    const { app, commands } = tuned();
    app.setMode('whatif');
    app.set({ [K_P]: 700000 });
    await app.play({ changed: false });
    expect(app.api.patch).not.toHaveBeenCalled();
    expect(app.pending).toBe(1);
    await app.playOrPause();
    await app.playOrPause();
    expect(app.api.patch).toHaveBeenCalledWith('s0', { [K_P]: 700000 });
    expect(app.pending).toBe(0);
    expect(commands).toEqual(['play', 'pause', 'play']);
  });

  it('does not play where the changes are refused', async () => {
    const { app, commands } = tuned();
    app.setMode('whatif');
    app.set({ [K_P]: -5 });
    app.api.patch = vi.fn(() => Promise.reject(new Error('Is out of range')));
    await app.playOrPause();
    expect(commands).toEqual([]);
    expect(app.pending).toBe(1);
  });

  it('starts a finished session again', async () => {
    const { app, commands } = tuned();
    app.session.info = { ...app.session.info, state: 'finished' } as SessionInfo;
    await app.playOrPause();
    expect(commands).toEqual(['reset', 'play']);
  });
});
