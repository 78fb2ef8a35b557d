/**
 * One session's stream: connects, subscribes, acknowledges, and comes back by itself.
 *
 * After a lost connection it requests the ticks from the end of the ring. On a slow line curves are
 * thinned to extremes; ticks that the server thinned or skipped are fetched once the line has room. What the server no longer has stays a gap.
 */

import type { ClientMessage, ServerMessage, SessionInfo } from '../api/types';
import { Backfill } from './backfill';
import { decodeFrame } from './frame';
import type { Channel } from '../../plot/source';
import { capacityFor, type Computed, Ring } from './ring';

/** How long to wait before each further attempt to connect: doubling, bounded, a little scattered. */
export class Backoff {
  private failures = 0;

  constructor(
    private readonly first = 250,
    private readonly longest = 5000,
    private readonly random: () => number = Math.random,
  ) {}

  /** Returns the milliseconds until the next attempt and counts it. */
  next(): number {
    const wait = Math.min(this.longest, this.first * 2 ** this.failures);
    this.failures += 1;
    // Scattered, so that all pages of a restarted server do not come at the same instant.
    return wait * (0.8 + 0.4 * this.random());
  }

  /** Clears the failures once connected. */
  reset(): void {
    this.failures = 0;
  }
}

/** Who watches: the name that was given, and a key that all streams of the browser have. */
export interface Person {
  name: string;
  key: string;
}

export type Connection = 'connecting' | 'connected' | 'lost' | 'closed';

export interface StreamEvents {
  connection(state: Connection): void;
  /** Ticks per second. */
  rate(rate: number): void;
  /** Everything that can be subscribed to. */
  channels(channels: readonly Channel[]): void;
  session(info: SessionInfo): void;
  /** The name by which others see who watches here. */
  named(name: string): void;
  reset(): void;
  problem(detail: string): void;
}

/** The part of a WebSocket that is used; tests bring their own. */
export interface Socket {
  binaryType: BinaryType;
  onopen: ((event: Event) => void) | null;
  onmessage: ((event: MessageEvent) => void) | null;
  onclose: ((event: CloseEvent) => void) | null;
  send(data: string): void;
  close(): void;
}

export interface StreamOptions {
  /**
   * Asked before each further attempt: whether the session is still worth connecting to. A failure
   * counts as no.
   */
  alive(): Promise<boolean>;
  /** Time for which samples are kept, s. */
  seconds: number;
  socket?: (url: string) => Socket;
  backoff?: Backoff;
  now?: () => number;
}

export class StreamClient {
  ring: Ring;
  /** Counts since the client was made; who reads them takes differences. */
  readonly counts = { frames: 0, samples: 0, dropped: 0, bytes: 0 };
  /** Ticks that a sample of the newest frame stands for: above 1 on a slow line. */
  stride = 1;
  /** Longest time from a sample until it was here, lately, s; null before it is known. */
  delay: number | null = null;
  /** When the newest frame came in, in ms of performance.now(). */
  receivedAt = 0;
  /** When the newest message of any kind came in, ms; null before the first. */
  heardAt: number | null = null;
  private socket: Socket | null = null;
  private timer: ReturnType<typeof setTimeout> | null = null;
  private subscription: readonly string[] = [];
  /** Columns that the session has. */
  private known: ReadonlySet<string> = new Set();
  private computed: readonly Computed[] = [];
  /** What the frames now coming in consist of; null until the server has confirmed. */
  private confirmed: readonly string[] | null = null;
  private pending: readonly string[] | null = null;
  private person: Person | null = null;
  private closed = false;
  private greeted = false;
  private capacity = 0;
  /** Which of the session's timelines the ring holds. */
  private timeline = 0;
  private readonly backoff: Backoff;
  private readonly backfill = new Backfill(
    () => this.newSocket(),
    () => this.ring,
  );

  constructor(
    private readonly url: string,
    private readonly events: StreamEvents,
    private readonly options: StreamOptions,
  ) {
    this.ring = new Ring(0, []);
    this.backoff = options.backoff ?? new Backoff();
  }

  connect(): void {
    this.closed = false;
    this.events.connection('connecting');
    this.open();
  }

  close(): void {
    this.closed = true;
    if (this.timer !== null) clearTimeout(this.timer);
    this.backfill.clear();
    this.greeted = false;
    this.socket?.close();
    this.socket = null;
    this.events.connection('closed');
  }

  /** Asks for other columns; samples that the server still holds come again with them. */
  subscribe(columns: readonly string[]): void {
    const before = this.available.join();
    this.subscription = columns;
    const same = before === this.available.join();
    // One request at a time: a newer one is sent after the answer.
    if (this.greeted && !same && this.pending === null && this.available.length > 0) this.send();
  }

  /** What there is of the subscription: one unknown column must not cost all others. */
  private get available(): readonly string[] {
    const { known, subscription } = this;
    return known.size === 0 ? subscription : subscription.filter((column) => known.has(column));
  }

  /** Says who watches, now and after each further connection. */
  introduce(person: Person): void {
    this.person = person;
    if (this.greeted) this.say({ type: 'person', ...person });
  }

  /** Columns to compute from those that come. */
  compute(computed: readonly Computed[]): void {
    this.computed = computed;
    this.ring.compute(computed);
  }

  /** Connections of this page to the session: a second one while skipped ticks are fetched. */
  get connections(): number {
    return (this.greeted ? 1 : 0) + (this.backfill.connected ? 1 : 0);
  }

  /** Opens the stream anew in place of a connection that has died without a word. */
  reconnect(): void {
    const { socket } = this;
    if (socket === null || this.closed) return;
    this.socket = null;
    socket.close();
    this.lost();
  }

  private now(): number {
    return (this.options.now ?? performance.now.bind(performance))();
  }

  private newSocket(): Socket {
    return this.options.socket ? this.options.socket(this.url) : new WebSocket(this.url);
  }

  private open(): void {
    const socket = this.newSocket();
    this.socket = socket;
    this.delay = null;
    this.greeted = false;
    this.confirmed = null;
    this.pending = null;
    socket.binaryType = 'arraybuffer';
    socket.onmessage = (event) => {
      if (socket !== this.socket) return;
      this.heardAt = this.now();
      if (typeof event.data === 'string') this.message(JSON.parse(event.data) as ServerMessage);
      else this.frame(event.data as ArrayBuffer);
    };
    socket.onclose = () => {
      if (socket === this.socket && !this.closed) this.lost();
    };
  }

  private lost(): void {
    this.socket = null;
    this.greeted = false;
    this.backfill.suspend();
    this.events.connection('lost');
    this.timer = setTimeout(() => void this.retry(), this.backoff.next());
  }

  private async retry(): Promise<void> {
    const alive = await this.options.alive().catch((error: unknown) => {
      this.events.problem(error instanceof Error ? error.message : String(error));
      return false;
    });
    if (this.closed) return;
    if (!alive) {
      this.lost();
      return;
    }
    this.open();
  }

  private send(): void {
    const columns = this.available;
    this.pending = columns;
    const resumes = this.matches(columns) && this.ring.end > this.ring.start;
    const from_tick = resumes ? this.ring.end : this.ring.start;
    this.say({ type: 'subscribe', columns: [...columns], from_tick, when_behind: 'thin' });
  }

  private say(message: ClientMessage): void {
    this.socket?.send(JSON.stringify(message));
  }

  private matches(columns: readonly string[]): boolean {
    return columns.length === this.ring.names.length && columns.every((c) => this.ring.has(c));
  }

  private message(message: ServerMessage): void {
    switch (message.type) {
      case 'hello':
        this.greeted = true;
        this.backoff.reset();
        this.events.connection('connected');
        this.capacity = capacityFor(this.options.seconds, message.rate);
        this.events.rate(message.rate);
        this.events.channels(message.columns);
        this.known = new Set(message.columns.map(({ name }) => name));
        this.events.session(message.session);
        // The session may have been reset while disconnected.
        if (message.session.timeline !== this.timeline) this.clear();
        this.timeline = message.session.timeline;
        if (this.person) this.introduce(this.person);
        if (this.available.length > 0) this.send();
        break;
      case 'subscribed': {
        const columns = this.pending;
        if (!columns) break;
        const same =
          message.columns.length === this.ring.names.length &&
          message.columns.every((column, i) => column === this.ring.names[i]);
        if (!same) {
          this.backfill.clear();
          this.ring = new Ring(this.capacity, message.columns);
          this.ring.compute(this.computed);
        }
        this.backfill.resume();
        this.confirmed = columns;
        this.pending = null;
        if (this.available.join() !== columns.join()) this.send();
        break;
      }
      case 'named':
        this.events.named(message.name);
        break;
      case 'gap':
        this.counts.dropped += message.frames;
        this.backfill.skipped(message.from_tick, message.to_tick, this.timeline);
        break;
      case 'delay':
        this.delay = message.seconds;
        break;
      case 'session':
        this.timeline = message.session.timeline;
        this.events.session(message.session);
        break;
      case 'reset':
        this.clear();
        this.events.reset();
        break;
      case 'error':
        this.pending = null;
        this.events.problem(message.problem.detail);
        break;
      default:
        message satisfies never;
    }
  }

  private clear(): void {
    this.backfill.clear();
    this.ring.clear();
  }

  private frame(data: ArrayBuffer): void {
    const frame = decodeFrame(data);
    this.say({ type: 'ack', sequence: frame.sequence });
    if (!this.confirmed || frame.columns.length !== this.ring.names.length) return;
    const { tick, samples, stride } = frame;
    this.ring.write(tick, frame.columns, stride);
    // What comes at rest fills bins of its own, shorter ones.
    if (stride > 1) this.backfill.skipped(tick, tick + samples * stride, this.timeline);
    this.stride = stride;
    this.counts.frames += 1;
    this.counts.samples += samples;
    this.counts.bytes += data.byteLength;
    this.receivedAt = this.now();
  }
}
