import { expect, it, vi } from 'vitest';
import type { Api } from '../api/client';
import { numberAt } from '../api/scenario-paths';
import type { Changes, SessionInfo } from '../api/types';
import { SessionStore } from './session.svelte';

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

const K_P = 'variants.B.controller.x.k_p';
const DELAY = 'variants.B.controller.delay';

const patched: Changes[] = [];

function info(id: string, k_p: number, more: object = {}): SessionInfo {
  const B = { controller: { delay: id === 'home' ? 0 : 1, x: { k_p } } };
  const A = { controller: { delay: 0, x: { k_p: 9 } } };
  const variants = id === 'home' ? { A, B } : { B };
  const drive = id === 'home' ? '' : 'Virtual drive';
  const scenario = { name: 'circle', variants };
  const state = {
    changes: [],
    events: [],
    revision: 0,
    stream: '',
    state: 'playing',
    speed: 1,
    time: 0,
  };
  return { id, drive, base: scenario, scenario, ...state, ...more } as unknown as SessionInfo;
}

/** A session from which B was begun on drives, with these what-if changes. */
function moving(draft: Changes) {
  const undone = vi.fn(() => Promise.resolve(info('motion', 1, { revision: 2 })));
  patched.length = 0;
  const patch = (_: string, set: Changes) => {
    patched.push(set);
    return Promise.resolve({ tick: 5 });
  };
  const api = { patch, command: undone };
  const store = new SessionStore(api as unknown as Api);
  const home = info('home', 1);
  [store.info, store.base, store.draft, store.missing] = [home, home.scenario, draft, ''];
  store.showMotion(info('motion', draft[K_P] === undefined ? 1 : (draft[K_P] as number)));
  return store;
}

it('shows the gains of the variant that moves, and those of the others as they were', async () => {
  const store = moving({ 'variants.A.controller.x.k_p': 7 });
  await store.patch({ [K_P]: 3 });
  const { scenario } = store.info as SessionInfo;
  expect(numberAt(scenario, K_P)).toBe(3);
  expect(numberAt(scenario, DELAY)).toBe(0);
  expect(numberAt(scenario, 'variants.A.controller.x.k_p')).toBe(7);
});

it('leaves changes of a variant that does not move for its own motion', async () => {
  const store = moving({});
  const A = 'variants.A.controller.x.k_p';
  await store.patch({ [A]: 4 });
  expect(patched).toEqual([]);
  expect(store.draft).toEqual({ [A]: 4 });
  expect(numberAt(store.info?.scenario ?? null, A)).toBe(4);
  await store.patch({ [A]: 5, [K_P]: 3 });
  expect(patched).toEqual([{ [K_P]: 3 }]);
});

it.each<[string, Changes]>([
  ['nothing', {}],
  ['an earlier change', { [K_P]: 2 }],
])(
  'keeps what was changed on drives as a what-if change, and undo leaves %s',
  async (_, before) => {
    const store = moving(before);
    await store.patch({ [K_P]: 3 });
    expect(store.draft).toEqual({ [K_P]: 3 });
    const previous = { [K_P]: before[K_P] ?? 1 };
    const changes = [{ tick: 5, set: { [K_P]: 3 }, previous }];
    store.info = { ...(store.info as SessionInfo), changes };
    await store.undo();
    expect(store.draft).toEqual(before);
  },
);
