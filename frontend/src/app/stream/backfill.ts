/**
 * Fetches the ticks that the server skipped or thinned because this page or its line was slow.
 *
 * The server holds the last 30 s. The ticks come over a second connection that lives as long as there
 * are any to fetch: asked for on the first one, they would come in place of live frames, and the
 * display would stand still until they were all there. Nothing is fetched until no frames have been
 * skipped or thinned for a while; when that happens again in spite of it, the page is too busy, and fetching
 * waits twice as long.
 */

import type { ClientMessage, ServerMessage } from '../api/types';
import { decodeFrame } from './frame';
import type { Ring } from './ring';
import type { Socket } from './stream-client';

/** Time without a skipped frame before fetching begins, ms. */
const PAUSE = 1000;
const LONGEST_PAUSE = 16_000;

interface Gap {
  from: number;
  /** The tick after its last. */
  to: number;
}

export class Backfill {
  private gaps: Gap[] = [];
  private socket: Socket | null = null;
  private timer: ReturnType<typeof setTimeout> | null = null;
  private pause = PAUSE;
  private timeline = 0;
  /** First tick requested on this connection; earlier frames may still arrive. */
  private requestedFrom = -1;

  /** @param ring where the ticks go; read anew each time, as other columns need another ring */
  constructor(
    private readonly connect: () => Socket,
    private readonly ring: () => Ring,
  ) {}

  get connected(): boolean {
    return this.socket !== null;
  }

  /** Notes ticks that were skipped, or thinned, in a timeline. */
  skipped(from: number, to: number, timeline: number): void {
    if (this.socket) this.pause = Math.min(LONGEST_PAUSE, 2 * this.pause);
    this.timeline = timeline;
    const last = this.gaps.at(-1);
    if (last?.to === from) last.to = to;
    else this.gaps.push({ from, to });
    this.later();
  }

  /** Goes on after the first connection has come back. */
  resume(): void {
    if (this.gaps.length > 0) this.later();
  }

  /** Fetches nothing until it is resumed. */
  suspend(): void {
    if (this.timer !== null) clearTimeout(this.timer);
    this.timer = null;
    this.disconnect();
  }

  /** Forgets the gaps: their ticks are void, or come with another subscription. */
  clear(): void {
    this.suspend();
    this.gaps = [];
    this.pause = PAUSE;
  }

  private later(): void {
    this.suspend();
    this.timer = setTimeout(() => this.open(), this.pause);
  }

  private open(): void {
    this.timer = null;
    if (!this.outstanding()) return;
    const socket = this.connect();
    this.socket = socket;
    this.requestedFrom = -1;
    socket.binaryType = 'arraybuffer';
    socket.onmessage = ({ data }: MessageEvent) => {
      if (socket !== this.socket) return;
      if (typeof data === 'string') this.message(JSON.parse(data) as ServerMessage);
      else this.frame(data as ArrayBuffer);
    };
    socket.onclose = () => {
      if (socket !== this.socket) return;
      this.pause = Math.min(LONGEST_PAUSE, 2 * this.pause);
      this.later();
    };
  }

  private disconnect(): void {
    const { socket } = this;
    this.socket = null;
    socket?.close();
  }

  private message(message: ServerMessage): void {
    switch (message.type) {
      case 'hello':
        if (message.session.timeline === this.timeline) this.ask();
        else this.clear();
        break;
      case 'subscribed':
        // What lies before is no longer held by the server.
        this.remove(0, message.from_tick);
        this.finish();
        break;
      case 'gap':
        // This connection was slow too: its ticks are requested again.
        this.ask();
        break;
      case 'reset':
      case 'error':
        this.clear();
        break;
      case 'session':
      case 'named':
      case 'delay':
        break;
      default:
        message satisfies never;
    }
  }

  private frame(data: ArrayBuffer): void {
    const { sequence, tick, samples, columns } = decodeFrame(data);
    this.say({ type: 'ack', sequence });
    this.ring().patch(tick, columns);
    this.remove(tick, tick + samples);
    if (this.finish()) return;
    // Between this gap and the next there is nothing to fetch.
    const next = (this.gaps[0] as Gap).from;
    if (next > tick + samples && next !== this.requestedFrom) this.ask();
  }

  private ask(): void {
    if (!this.outstanding()) {
      this.finish();
      return;
    }
    this.requestedFrom = (this.gaps[0] as Gap).from;
    this.say({
      type: 'subscribe',
      columns: [...this.ring().names],
      from_tick: this.requestedFrom,
      when_behind: 'wait',
    });
  }

  private say(message: ClientMessage): void {
    this.socket?.send(JSON.stringify(message));
  }

  /** Ends the connection once nothing is left to fetch; returns whether that is so. */
  private finish(): boolean {
    if (this.gaps.length > 0) return false;
    this.pause = PAUSE;
    this.disconnect();
    return true;
  }

  /** Forgets the part of the gaps that the ring has given up; returns whether any is left. */
  private outstanding(): boolean {
    this.remove(0, this.ring().start);
    return this.gaps.length > 0;
  }

  private remove(from: number, to: number): void {
    this.gaps = this.gaps
      .flatMap((gap) => [
        { from: gap.from, to: Math.min(gap.to, from) },
        { from: Math.max(gap.from, to), to: gap.to },
      ])
      .filter((gap) => gap.from < gap.to)
      .sort((a, b) => a.from - b.from);
  }
}
