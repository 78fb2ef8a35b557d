/** The session on the server: which one, its state, its stream, and how it is found again. */

import { ApiError, UNREACHABLE, type Api, type ScenarioRequest } from '../api/client';
import { withChanges } from '../api/paths';
import type { Axis, Changes, Scenario, SessionInfo } from '../api/types';
import type { Moment } from '../scope/chart';
import { StreamClient, type Connection, type Subscription } from '../stream/client';
import { messages } from '../ui/messages.svelte';
import { fromAddress, load, save, setAddress } from '../ui/storage';

/** Ticks that are kept: 33 s, a little more than the server has to resume from. */
const CAPACITY = 65_536;
export const PERIOD = 0.0005;
export const PUSH_SECONDS = 0.05;
/** Simulated over real time. */
export const SPEED = { least: 0.1, most: 10 };

/** What is kept of a session, so that it can be made again when the server has lost it. */
interface Kept {
  id: string;
  base: Scenario;
  scenario: Scenario;
}

export class SessionStore {
  info = $state.raw<SessionInfo | null>(null);
  /** What differences are shown against: the scenario as it was loaded. */
  base = $state.raw<Scenario | null>(null);
  connection = $state<Connection>('connecting');
  speed = $state(load('speed', 1));
  pushes = $state.raw<readonly Moment[]>([]);
  /** Set between pressing STOP and the server's answer. */
  stopping = $state(false);
  client: StreamClient | null = null;
  private subscription: Subscription = { columns: [], differences: [] };
  /** Whether the session that was asked for last has come; pending until the server has answered. */
  private making = Promise.resolve(true);
  private stops = 0;

  constructor(private readonly api: Api) {}

  get id(): string {
    return this.info?.id ?? '';
  }

  /** The session that a command is for. */
  private get target(): string {
    if (!this.info) throw new Error('There is no session yet: the server has not answered.');
    return this.info.id;
  }

  /** Time that the newest sample stands for. */
  get time(): number {
    const ring = this.client?.ring;
    return ring && ring.end > ring.start ? ring.end * PERIOD : (this.info?.time ?? 0);
  }

  /** Finds the session of the address or of the last visit, or makes one. */
  async open(): Promise<void> {
    const kept = load<Kept | null>('session', null);
    const id = fromAddress('session') ?? kept?.id;
    if (id === undefined) {
      await this.create({});
      return;
    }
    try {
      const info = await this.api.session(id);
      this.adopt(info, (kept?.id === id ? kept.base : null) ?? info.base);
    } catch (error) {
      if (!(error instanceof ApiError) || error.status !== 404) throw error;
      await this.recreate(kept?.id === id ? kept : null);
    }
  }

  /** Makes a session, after those that were asked for before; the present one ends. */
  create(request: ScenarioRequest, base?: Scenario): Promise<void> {
    const made = this.making.then(() => this.make(request, base));
    this.making = made.then(
      () => true,
      () => false,
    );
    return made;
  }

  /**
   * Waits for a session that is being made: a command given meanwhile is meant for that one. False
   * where it must not be carried out, as there is none, or STOP was pressed after it.
   */
  async settled(): Promise<boolean> {
    const { stops } = this;
    return (await this.making) && stops === this.stops;
  }

  /** Makes a session; the present one ends unless somebody else watches it. */
  private async make(request: ScenarioRequest, base?: Scenario): Promise<void> {
    const before = this.id;
    const info = await this.api.create(request);
    const alone = before !== '' && (await this.alone(before).catch(() => false));
    this.adopt(info, base ?? info.base);
    if (alone) await this.api.remove(before).catch(() => undefined);
  }

  /** Whether nobody else watches the session. Asked while our own stream still counts. */
  private async alone(id: string): Promise<boolean> {
    const own = this.connection === 'connected' ? 1 : 0;
    const { watchers } = await this.api.session(id);
    return watchers <= own;
  }

  subscribe(subscription: Subscription): void {
    this.subscription = subscription;
    this.client?.subscribe(subscription);
  }

  async play(): Promise<void> {
    this.update(await this.api.command(this.target, 'play', { speed: this.speed }));
  }

  async pause(): Promise<void> {
    this.update(await this.api.command(this.target, 'pause'));
  }

  async step(ticks: number): Promise<void> {
    this.update(await this.api.command(this.target, 'step', { ticks }));
  }

  async reset(): Promise<void> {
    this.update(await this.api.command(this.target, 'reset'));
  }

  async undo(): Promise<void> {
    this.update(await this.api.command(this.target, 'undo'));
  }

  async stop(): Promise<void> {
    const { target } = this;
    this.stops += 1;
    this.stopping = true;
    try {
      this.update(await this.api.command(target, 'stop'));
    } catch (error) {
      // One that was replaced meanwhile no longer moves, and the new one has not begun to.
      if (target === this.id) throw error;
    } finally {
      this.stopping = false;
    }
  }

  async setSpeed(speed: number): Promise<void> {
    const within = Math.min(SPEED.most, Math.max(SPEED.least, speed));
    this.speed = Number(within.toPrecision(2));
    save('speed', this.speed);
    if (this.info?.state === 'playing') await this.play();
  }

  async push(axis: Axis, force: number): Promise<void> {
    const { tick } = await this.api.push(this.target, { axis, force, duration: PUSH_SECONDS });
    this.pushes = [...this.pushes, { time: tick * PERIOD, label: `push ${axis}` }];
  }

  /** Changes parameters of the running session; the server says at which tick. */
  async patch(set: Changes): Promise<void> {
    await this.api.patch(this.target, set);
    // The stream brings the server's own account; until then the controls need not jump back.
    if (this.info) this.info = { ...this.info, scenario: withChanges(this.info.scenario, set) };
  }

  private update(info: SessionInfo): void {
    if (info.id !== this.info?.id || info.revision < this.info.revision) return;
    this.info = info;
    this.keep();
  }

  private adopt(info: SessionInfo, base: Scenario): void {
    this.client?.close();
    this.info = info;
    this.base = base;
    this.pushes = [];
    if (info.state === 'playing') this.speed = info.speed;
    setAddress({ session: info.id });
    this.keep();
    const protocol = location.protocol === 'https:' ? 'wss' : 'ws';
    this.client = new StreamClient(
      `${protocol}://${location.host}${info.stream}`,
      {
        connection: (state) => (this.connection = state),
        session: (news) => this.update(news),
        reset: () => (this.pushes = []),
        problem: (detail) => messages.error(detail),
      },
      { capacity: CAPACITY, alive: () => this.alive(info.id) },
    );
    this.client.subscribe(this.subscription);
    this.client.connect();
  }

  private keep(): void {
    if (!this.info || !this.base) return;
    const { id, scenario } = this.info;
    save('session', { id, base: this.base, scenario } satisfies Kept);
  }

  /** Whether the session is still there; makes it again when the server has lost it. */
  private async alive(id: string): Promise<boolean> {
    try {
      this.update(await this.api.session(id));
      return true;
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      if (error.status === 404 && id === this.info?.id) {
        const { base, info } = this;
        await this.recreate(base ? { id, base, scenario: info.scenario } : null);
      } else if (error.status !== UNREACHABLE) {
        messages.error(error.message);
      }
      return false;
    }
  }

  private async recreate(kept: Kept | null): Promise<void> {
    this.info = null;
    if (!kept) {
      await this.create({});
      messages.info('The session of this address no longer exists. A new one was made.');
      return;
    }
    try {
      await this.create({ scenario: kept.scenario }, kept.base);
    } catch (error) {
      if (!(error instanceof ApiError) || error.status !== 422) throw error;
      // What an older version or a damaged storage has kept must not keep the page from opening.
      await this.create({});
      messages.error(`The session was gone, and what was kept of it is refused. ${error.message}`);
      return;
    }
    messages.info(
      'The session was gone: another tab has left it, the server was restarted, or it had been idle ' +
        'for long. It was made again from the scenario and the changes kept here, and is paused at 0 s.',
    );
  }
}
