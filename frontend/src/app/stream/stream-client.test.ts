import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { SessionInfo } from '../api/types';
import { Backoff, type Connection, type Socket, StreamClient } from './stream-client';

class FakeSocket implements Socket {
  binaryType: BinaryType = 'blob';
  onopen = null;
  onmessage: ((event: MessageEvent) => void) | null = null;
  onclose: ((event: CloseEvent) => void) | null = null;
  readonly sent: Record<string, unknown>[] = [];
  send(data: string): void {
    this.sent.push(JSON.parse(data) as Record<string, unknown>);
  }
  close(): void {
    this.drop();
  }
  drop(): void {
    this.onclose?.({} as CloseEvent);
  }
  say(message: object): void {
    this.onmessage?.({ data: JSON.stringify(message) } as MessageEvent);
  }
  hello(tick: number, timeline = 0, names = ''): void {
    const columns = [...names].map((name) => ({ name, unit: 'm' }));
    this.say({ type: 'hello', columns, rate: 2000, session: { tick, timeline } as SessionInfo });
  }
  frame(sequence: number, tick: number, columns: number[][], stride = 1): void {
    const samples = columns[0]?.length ?? 0;
    const head = stride > 1 ? 32 : 24;
    const data = new ArrayBuffer(head + 4 * columns.length * samples);
    const view = new DataView(data);
    [0x50, 0x53, 0x52, 0x4d].forEach((byte, i) => view.setUint8(i, byte));
    view.setUint16(4, stride > 1 ? 2 : 1, true);
    if (stride > 1) view.setUint32(24, stride, true);
    view.setUint16(6, columns.length, true);
    view.setUint32(8, sequence, true);
    view.setUint32(12, samples, true);
    view.setBigUint64(16, BigInt(tick), true);
    new Float32Array(data, head).set(columns.flat());
    this.onmessage?.({ data } as MessageEvent);
  }
}

function setUp(alive = () => Promise.resolve(true)) {
  const sockets: FakeSocket[] = [];
  const states: Connection[] = [];
  const events = {
    connection: (state: Connection) => states.push(state),
    rate: vi.fn(),
    channels: vi.fn(),
    session: vi.fn(),
    named: vi.fn(),
    reset: vi.fn(),
    problem: vi.fn(),
  };
  const client = new StreamClient('ws://test', events, {
    alive,
    seconds: 0.512,
    backoff: new Backoff(250, 5000, () => 0.5),
    now: () => 7,
    socket: () => {
      const socket = new FakeSocket();
      sockets.push(socket);
      return socket;
    },
  });
  client.subscribe(['p', 'q']);
  client.connect();
  const newest = () => sockets.at(-1) as FakeSocket;
  return { client, events, states, sockets, newest };
}

const subscribed = (from_tick: number, columns = ['p', 'q']) => ({
  type: 'subscribed',
  columns,
  from_tick,
});

describe('StreamClient', () => {
  beforeEach(() => void vi.useFakeTimers());
  afterEach(() => void vi.useRealTimers());

  it('does without a column that the session has not', () => {
    const { client, newest } = setUp();
    newest().hello(0, 0, 'pr');
    client.subscribe(['p', 'q', 'r']);
    newest().say(subscribed(0, ['p']));
    expect(newest().sent.map((each) => (each as { columns: string[] }).columns)).toEqual([
      ['p'],
      ['p', 'r'],
    ]);
  });

  it('subscribes after hello, takes frames in and acknowledges them', () => {
    const { client, newest, states } = setUp();
    newest().hello(0);
    expect(newest().sent).toEqual([
      { type: 'subscribe', columns: ['p', 'q'], from_tick: 0, when_behind: 'thin' },
    ]);
    newest().say(subscribed(0));
    newest().frame(0, 0, [
      [1, 2],
      [3, 4],
    ]);
    expect(client.ring.at('q', 1)).toBe(4);
    expect(newest().sent.at(-1)).toEqual({ type: 'ack', sequence: 0 });
    expect(client.counts).toMatchObject({ frames: 1, samples: 2, dropped: 0 });
    expect(states).toEqual(['connecting', 'connected']);
  });

  it('comes back by itself and resumes where the ring ends', async () => {
    const { client, newest, sockets, states } = setUp();
    newest().hello(0);
    newest().say(subscribed(0));
    newest().frame(0, 0, [
      [1, 2],
      [3, 4],
    ]);
    newest().drop();
    expect(states.at(-1)).toBe('lost');
    await vi.advanceTimersByTimeAsync(240);
    expect(sockets.length).toBe(1);
    await vi.advanceTimersByTimeAsync(20);
    expect(sockets.length).toBe(2);
    newest().hello(50);
    expect(newest().sent).toEqual([
      { type: 'subscribe', columns: ['p', 'q'], from_tick: 2, when_behind: 'thin' },
    ]);
    newest().say(subscribed(40));
    newest().frame(0, 40, [[5], [6]]);
    expect(client.ring.at('p', 1)).toBe(2);
    expect(client.ring.at('p', 20)).toBeNaN();
    expect(client.ring.at('p', 40)).toBe(5);
  });

  it('forgets the samples of a timeline that ended while it was away', async () => {
    const { client, newest } = setUp();
    newest().hello(0);
    newest().say(subscribed(0));
    newest().frame(0, 0, [
      [1, 2],
      [3, 4],
    ]);
    newest().drop();
    await vi.advanceTimersByTimeAsync(260);
    newest().hello(50, 1);
    expect(client.ring.end).toBe(0);
    expect(newest().sent).toEqual([
      { type: 'subscribe', columns: ['p', 'q'], from_tick: 0, when_behind: 'thin' },
    ]);
  });

  it('waits longer after each failure, and not after success', async () => {
    const alive = vi.fn(() => Promise.resolve(false));
    const { newest, sockets } = setUp(alive);
    newest().drop();
    await vi.advanceTimersByTimeAsync(250 + 500 + 1000 + 2000 + 4000 + 5000 + 5000);
    expect(alive).toHaveBeenCalledTimes(7);
    expect(sockets.length).toBe(1);
    alive.mockResolvedValue(true);
    await vi.advanceTimersByTimeAsync(5000);
    newest().hello(0);
    newest().drop();
    await vi.advanceTimersByTimeAsync(250);
    expect(sockets.length).toBe(3);
  });

  it('stays closed once closed', async () => {
    const { client, sockets, states } = setUp();
    client.close();
    await vi.advanceTimersByTimeAsync(60_000);
    expect(sockets.length).toBe(1);
    expect(states.at(-1)).toBe('closed');
  });

  it('counts dropped frames and forgets on reset', () => {
    const { client, events, newest } = setUp();
    newest().hello(0);
    newest().say(subscribed(0));
    newest().frame(0, 0, [[1], [2]]);
    newest().say({ type: 'gap', from_tick: 1, to_tick: 100, frames: 3 });
    newest().frame(1, 100, [[3], [4]]);
    expect(client.counts.dropped).toBe(3);
    expect(client.ring.at('p', 50)).toBeNaN();
    newest().say({ type: 'reset' });
    expect(client.ring.end).toBe(0);
    expect(events.reset).toHaveBeenCalledOnce();
  });

  it('draws skipped ticks as a gap until they are fetched over a second connection', async () => {
    const { client, newest, sockets } = setUp();
    newest().hello(0);
    newest().say(subscribed(0));
    newest().frame(0, 0, [
      [1, 2],
      [3, 4],
    ]);
    newest().say({ type: 'gap', from_tick: 2, to_tick: 4, frames: 1 });
    newest().frame(1, 4, [[5], [6]]);
    expect(client.ring.at('p', 3)).toBeNaN();
    expect(client.connections).toBe(1);
    await vi.advanceTimersByTimeAsync(1100);
    expect([sockets.length, client.connections]).toEqual([2, 2]);
    const [live, late] = sockets as [FakeSocket, FakeSocket];
    late.hello(5);
    expect(late.sent).toEqual([
      { type: 'subscribe', columns: ['p', 'q'], from_tick: 2, when_behind: 'wait' },
    ]);
    // Live frames go on meanwhile.
    live.frame(2, 5, [[7], [8]]);
    late.say(subscribed(2));
    late.frame(0, 2, [
      [20, 30, 5],
      [40, 50, 6],
    ]);
    expect([2, 3, 4, 5].map((tick) => client.ring.at('p', tick))).toEqual([20, 30, 5, 7]);
    expect(client.connections).toBe(1);
  });

  it('draws thinned curves without a gap, and fetches every sample once the line has room', async () => {
    const { client, newest, sockets } = setUp();
    newest().hello(0);
    newest().say(subscribed(0));
    newest().frame(
      0,
      0,
      [
        [3, -1],
        [4, 0],
      ],
      4,
    );
    newest().say({ type: 'delay', seconds: 0.12 });
    expect([client.stride, client.delay]).toEqual([4, 0.12]);
    expect([0, 3, 4, 7].map((tick) => client.ring.at('p', tick))).toEqual([3, 3, -1, -1]);
    await vi.advanceTimersByTimeAsync(900);
    newest().frame(1, 8, [[5], [6]]);
    expect([client.stride, sockets.length]).toEqual([1, 1]);
    await vi.advanceTimersByTimeAsync(200);
    const late = newest();
    late.hello(9);
    expect(late.sent).toEqual([
      { type: 'subscribe', columns: ['p', 'q'], from_tick: 0, when_behind: 'wait' },
    ]);
    late.say(subscribed(0));
    late.frame(0, 0, [
      [0, 1, 2, 3, 2, 1, 0, -1],
      [4, 3, 2, 1, 0, 1, 2, 3],
    ]);
    expect([0, 3, 7].map((tick) => client.ring.at('p', tick))).toEqual([0, 3, -1]);
    expect(client.connections).toBe(1);
  });

  it('fetches nothing of what another subscription or timeline has made void', async () => {
    const { client, newest, sockets } = setUp();
    newest().hello(0);
    newest().say(subscribed(0));
    newest().frame(0, 0, [[1], [2]]);
    newest().say({ type: 'gap', from_tick: 1, to_tick: 4, frames: 1 });
    newest().frame(1, 4, [[5], [6]]);
    client.subscribe(['r']);
    newest().say(subscribed(0, ['r']));
    newest().frame(2, 0, [[1, 1, 1, 1, 1]]);
    await vi.advanceTimersByTimeAsync(10_000);
    newest().say({ type: 'gap', from_tick: 5, to_tick: 9, frames: 1 });
    newest().say({ type: 'reset' });
    await vi.advanceTimersByTimeAsync(10_000);
    expect(sockets.length).toBe(1);
  });

  it('asks for other columns from the oldest tick, one question at a time', () => {
    const { client, newest } = setUp();
    newest().hello(0);
    client.subscribe(['r']);
    client.subscribe(['s']);
    expect(newest().sent.length).toBe(1);
    newest().say(subscribed(0));
    expect(newest().sent.at(-1)).toEqual({
      type: 'subscribe',
      columns: ['s'],
      from_tick: 0,
      when_behind: 'thin',
    });
    newest().frame(0, 0, [[1], [2]]);
    newest().say(subscribed(0, ['s']));
    newest().frame(1, 0, [[9]]);
    expect([client.ring.at('s', 0), client.ring.at('p', 0)]).toEqual([9, Number.NaN]);
  });
});
