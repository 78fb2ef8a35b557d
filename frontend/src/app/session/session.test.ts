import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { ApiError, UNREACHABLE, type Api } from '../api/client';
import type { Scenario, SessionInfo } from '../api/types';
import { messages } from '../messages.svelte';
import { SessionStore } from './session.svelte';

const sockets: FakeSocket[] = [];

class FakeSocket {
  onmessage: ((event: { data: string }) => void) | null = null;
  onclose: (() => void) | null = null;
  constructor(readonly url: string) {
    sockets.push(this);
  }
  send(): void {}
  close(): void {}
  say(message: object): void {
    this.onmessage?.({ data: JSON.stringify(message) });
  }
}

const info = (id: string, compensation = false, revision = 0): SessionInfo =>
  ({
    id,
    revision,
    timeline: 0,
    state: 'playing',
    changes: [],
    watchers: 1,
    people: [],
    events: [],
    stream: `/api/v1/sessions/${id}/stream`,
    base: { name: 'circle', variants: {} },
    scenario: { name: 'circle', variants: { B: { controller: { compensation } } } },
  }) as unknown as SessionInfo;

const refusal = (status: number) =>
  new ApiError({ title: '', status, detail: `status ${status}`, errors: [] });

/** A store connected to session `a`, which the server then loses. */
async function connected() {
  const api = {
    session: vi.fn((id: string) => Promise.resolve(info(id))),
    create: vi.fn<() => Promise<SessionInfo>>(() => Promise.resolve(info('b'))),
    remove: vi.fn(() => Promise.resolve()),
    command: vi.fn((id: string) => Promise.resolve(info(id))),
  };
  vi.stubGlobal('location', new URL('http://127.0.0.1/?session=a'));
  const store = new SessionStore(api as unknown as Api);
  await store.open();
  newest().say({ type: 'hello', columns: [], session: info('a') });
  expect(store.connection).toBe('connected');
  return { store, api };
}

const newest = () => sockets.at(-1) as FakeSocket;

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal('WebSocket', FakeSocket);
  vi.stubGlobal('history', { replaceState: vi.fn() });
  sockets.length = 0;
  messages.list = [];
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

describe('a lost stream', () => {
  it.each([
    ['there is no room for another session', refusal(429)],
    ['the server goes down again', refusal(UNREACHABLE)],
    ['the server fails', refusal(500)],
    ['the server is restarting', refusal(503)],
    ['the answer is no answer', new SyntaxError('Unexpected end of JSON input')],
  ])('comes back though %s meanwhile', async (_, failure) => {
    const { store, api } = await connected();
    api.session.mockImplementation((id) =>
      id === 'b' ? Promise.resolve(info('b')) : Promise.reject(refusal(404)),
    );
    api.create.mockRejectedValue(failure);
    newest().onclose?.();
    await vi.advanceTimersByTimeAsync(30_000);
    expect(api.create.mock.calls.length).toBeGreaterThan(4);
    expect(store.connection).toBe('lost');
    // What was there is still shown, and a command says why it cannot be carried out.
    expect(store.info?.id).toBe('a');
    await expect(store.play()).rejects.toThrow('could not yet make it again');
    await expect(store.play()).rejects.toThrow(failure.message.replace(/\.$/, ''));

    api.create.mockResolvedValue(info('b'));
    await vi.advanceTimersByTimeAsync(6000);
    expect(newest().url).toContain('/b/stream');
    newest().say({ type: 'hello', columns: [], session: info('b') });
    expect([store.connection, store.info?.id]).toEqual(['connected', 'b']);
    await store.play();
    expect(api.command).toHaveBeenCalledWith('b', 'play', expect.anything());
  });

  it.each([429, 500, 503, UNREACHABLE, 403])(
    'comes back to its session after answers %i',
    async (status) => {
      const { store, api } = await connected();
      api.session.mockRejectedValue(refusal(status));
      newest().onclose?.();
      await vi.advanceTimersByTimeAsync(30_000);
      expect(api.session.mock.calls.length).toBeGreaterThan(4);
      api.session.mockResolvedValue(info('a'));
      await vi.advanceTimersByTimeAsync(6000);
      newest().say({ type: 'hello', columns: [], session: info('a') });
      expect([store.connection, store.info?.id]).toEqual(['connected', 'a']);
    },
  );

  it('is not told of again and again', async () => {
    const { api } = await connected();
    api.session.mockRejectedValue(refusal(404));
    api.create.mockRejectedValue(refusal(429));
    newest().onclose?.();
    await vi.advanceTimersByTimeAsync(60_000);
    expect(messages.list.map(({ text }) => text)).toEqual([
      expect.stringContaining('status 429. The page keeps trying.'),
    ]);
  });
});

it('takes commands again after a session that could not be made', async () => {
  const { store, api } = await connected();
  api.create.mockRejectedValueOnce(refusal(422));
  await expect(store.create({ scenario: 'none' })).rejects.toThrow('status 422');
  expect(await store.settled()).toBe(true);
});

it('does not carry out a command that was given for a session that could not be made', async () => {
  const { store, api } = await connected();
  api.create.mockRejectedValueOnce(refusal(422));
  const made = store.create({ scenario: 'none' });
  const settled = store.settled();
  await expect(made).rejects.toThrow('status 422');
  expect(await settled).toBe(false);
});

it('follows what the server says of the scenario, as when a scheduled event takes effect', async () => {
  const { store } = await connected();
  const compensated = () =>
    (store.info?.scenario as Scenario & { variants: Record<string, { controller: object }> })
      .variants['B']?.controller;
  expect(compensated()).toEqual({ compensation: false });
  newest().say({ type: 'session', session: info('a', true, 1) });
  expect(compensated()).toEqual({ compensation: true });
});
