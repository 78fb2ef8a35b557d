import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { SessionInfo } from '../api/types';
import { Backfill } from './backfill';
import { Ring } from './ring';
import type { Socket } from './stream-client';

const HELD = 4096;

/** A server that holds ticks whose values are their numbers, and sends frames of 64 of them. */
class Server implements Socket {
  static first = 0;
  static end = 0;
  static timeline = 0;
  static requests: number[] = [];
  binaryType: BinaryType = 'blob';
  onopen = null;
  onmessage: ((event: MessageEvent) => void) | null = null;
  onclose: ((event: CloseEvent) => void) | null = null;
  open = true;
  next = 0;

  close(): void {
    this.open = false;
  }
  send(text: string): void {
    const message = JSON.parse(text) as { type: string; from_tick: number };
    if (message.type !== 'subscribe') return;
    Server.requests.push(message.from_tick);
    this.next = Math.min(Math.max(message.from_tick, Server.first), Server.end);
    this.say({ type: 'subscribed', columns: ['p'], from_tick: this.next });
  }
  hello(): void {
    this.say({ type: 'hello', columns: [], session: { timeline: Server.timeline } as SessionInfo });
  }
  say(message: object): void {
    if (this.open) this.onmessage?.({ data: JSON.stringify(message) } as MessageEvent);
  }
  /** Sends so many frames, as many as there are ticks for and the page takes. */
  frames(most = 1000): void {
    for (let i = 0; i < most && this.open && this.next < Server.end; i++) {
      const from = this.next;
      this.next = Math.min(from + 64, Server.end);
      this.onmessage?.({ data: frame(from, this.next) } as MessageEvent);
    }
  }
}

function values(from: number, to: number): Float32Array {
  return Float32Array.from({ length: to - from }, (_, i) => from + i);
}

function frame(from: number, to: number): ArrayBuffer {
  const data = new ArrayBuffer(24 + 4 * (to - from));
  const view = new DataView(data);
  [0x50, 0x53, 0x52, 0x4d].forEach((byte, i) => view.setUint8(i, byte));
  view.setUint16(4, 1, true);
  view.setUint16(6, 1, true);
  view.setUint32(12, to - from, true);
  view.setBigUint64(16, BigInt(from), true);
  new Float32Array(data, 24).set(values(from, to));
  return data;
}

/** A ring that lacks some stretches of the ticks 0 to 2000, and what fills them. */
function lacking(...gaps: [number, number][]) {
  const ring = new Ring(HELD, ['p']);
  const sockets: Server[] = [];
  const backfill = new Backfill(
    () => {
      sockets.push(new Server());
      return sockets.at(-1) as Server;
    },
    () => ring,
  );
  let tick = 0;
  for (const [from, to] of [...gaps, [2000, 2000]] as const) {
    ring.write(tick, [values(tick, from)]);
    if (to > from) backfill.skipped(from, to, 0);
    tick = to;
  }
  const missing = () => {
    const ticks = Array.from({ length: ring.end }, (_, i) => i);
    return ticks.filter((i) => Number.isNaN(ring.at('p', i))).length;
  };
  return { ring, sockets, backfill, missing, newest: () => sockets.at(-1) as Server };
}

beforeEach(() => {
  vi.useFakeTimers();
  Object.assign(Server, { first: 0, end: 2000, timeline: 0, requests: [] });
});
afterEach(() => void vi.useRealTimers());

describe('Backfill', () => {
  it('fetches all gaps once none has come for a second, and ends its connection', () => {
    const { sockets, missing, newest } = lacking([300, 500], [600, 610], [1500, 1800]);
    expect(missing()).toBe(510);
    vi.advanceTimersByTime(900);
    expect(sockets.length).toBe(0);
    vi.advanceTimersByTime(200);
    newest().hello();
    newest().frames();
    expect(missing()).toBe(0);
    expect(newest().open).toBe(false);
    // What lies between far gaps is not fetched.
    expect(Server.requests).toEqual([300, 600, 1500]);
    vi.advanceTimersByTime(60_000);
    expect(sockets.length).toBe(1);
  });

  it('gives up what the server no longer holds', () => {
    const { missing, newest } = lacking([300, 500], [1500, 1800]);
    Server.first = 450;
    vi.advanceTimersByTime(1000);
    newest().hello();
    newest().frames();
    expect(missing()).toBe(150);
    expect(newest().open).toBe(false);
  });

  it('asks again where its own connection was too slow', () => {
    const { missing, newest } = lacking([300, 900]);
    vi.advanceTimersByTime(1000);
    newest().hello();
    newest().frames(3);
    newest().next = 1950;
    newest().say({ type: 'gap', from_tick: 492, to_tick: 1950, frames: 40 });
    expect(Server.requests).toEqual([300, 492]);
    newest().frames();
    expect(missing()).toBe(0);
  });

  it('lets live frames come first: skipped again it stops, and waits longer', () => {
    const { ring, backfill, sockets, missing, newest } = lacking([300, 900]);
    vi.advanceTimersByTime(1000);
    newest().hello();
    newest().frames(2);
    ring.write(2100, [values(2100, 2200)]);
    Server.end = 2200;
    backfill.skipped(2000, 2100, 0);
    expect(newest().open).toBe(false);
    vi.advanceTimersByTime(1500);
    expect(sockets.length).toBe(1);
    vi.advanceTimersByTime(600);
    newest().hello();
    newest().frames();
    expect(missing()).toBe(0);
    expect(Server.requests).toEqual([300, 428, 2000]);
  });

  it('comes back when its connection is lost', () => {
    const { sockets, missing, newest } = lacking([300, 900]);
    vi.advanceTimersByTime(1000);
    newest().onclose?.({} as CloseEvent);
    vi.advanceTimersByTime(2100);
    expect(sockets.length).toBe(2);
    newest().hello();
    newest().frames();
    expect(missing()).toBe(0);
  });

  it('fetches nothing of a timeline that is over', () => {
    const { sockets, missing, newest } = lacking([300, 900]);
    vi.advanceTimersByTime(1000);
    Server.timeline = 1;
    newest().hello();
    expect(newest().open).toBe(false);
    expect(Server.requests).toEqual([]);
    vi.advanceTimersByTime(60_000);
    expect([sockets.length, missing()]).toEqual([1, 600]);
  });

  it('waits while the first connection is away', () => {
    const { sockets, backfill, missing, newest } = lacking([300, 900]);
    backfill.suspend();
    vi.advanceTimersByTime(60_000);
    expect(sockets.length).toBe(0);
    backfill.resume();
    vi.advanceTimersByTime(1000);
    newest().hello();
    newest().frames();
    expect(missing()).toBe(0);
  });
});
