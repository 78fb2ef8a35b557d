/** The session on the server: which one, its state, its stream, and how it is found again. */

import { ApiError, PATIENCE, UNREACHABLE, type Api, type ScenarioRequest } from '../api/client';
import { at, atStart, equal, fitting, withChanges, without } from '../api/scenario-paths';
import type { Axis, Changes, Scenario, SessionInfo, Value } from '../api/types';
import { messages } from '../messages.svelte';
import { fromAddress, setAddress } from '../storage';
import type { Computed } from '../stream/ring';
import { RepeatedStop } from '../stop.svelte';
import { StreamClient, type Connection } from '../stream/stream-client';
import {
  forget,
  keptSessions,
  recall,
  remember,
  rememberDraft,
  withPath,
  type GivenPath,
  type Kept,
  type Own,
} from './kept-sessions';
import type { Channel } from '../../plot/source';
import { digits } from '../../ui/units';
import { declaredAs } from './declared';
import { lawText } from './law-text';
import { Moments, newLaw, newReset, newStop } from './moments.svelte';
import { person } from './person.svelte';

/** Time for which samples are kept, s: a little more than the server has to resume from. */
const KEPT = 33;
export const PUSH_SECONDS = 0.05;
/** Simulated over real time. */
export const SPEED = { least: 0.1, most: 10 };

/** Reason of a failure, to go into a sentence. */
function reason(error: unknown): string {
  return (error instanceof Error ? error.message : String(error)).replace(/\.$/, '');
}

export class SessionStore {
  info = $state.raw<SessionInfo | null>(null);
  /** Reference for differences: the scenario as it was loaded. */
  base = $state.raw<Scenario | null>(null);
  /** What-if changes that the session does not have. */
  draft = $state.raw<Changes>({});
  /** Paths that were given to it or tried in what-if, the last one first. */
  paths = $state.raw<readonly GivenPath[]>([]);
  connection = $state<Connection>('connecting');
  speed = $state(1);
  readonly moments = new Moments();
  /** The one that a motion on drives has; empty for a simulation, which has them all. */
  variant = $state('');
  /** STOP until the server has answered, for this session and those it has followed. */
  readonly halt = new RepeatedStop((signal) => this.sendStop(signal));
  private toStop: readonly string[] = [];
  /** Why there is no session on the server just now; empty while there is one. */
  missing = $state('There is no session yet: the server has not answered.');
  client: StreamClient | null = null;
  /** The session to go back to from a motion on drives; empty while one is shown. */
  private home = '';
  /** Of a motion on drives, which has one variant: the scenario that the controls go on showing. */
  private whole: Scenario | null = null;
  private subscription: readonly string[] = [];
  private computed: readonly Computed[] = [];
  /** The channels there are, once the server has named them. */
  channels = $state.raw<readonly Channel[]>([]);
  /** Whether the last requested session was created; pending until the server has answered. */
  private making = Promise.resolve(true);
  private stops = 0;
  /** What was last said of a law that was not taken, until another version is. */
  private lawProblem = '';

  /** Called when another version of a law's file has been taken. */
  onLaw: () => void = () => undefined;

  constructor(private readonly api: Api) {}

  get id(): string {
    return this.info?.id ?? '';
  }

  /** Its scenario as it holds at 0 s, before the schedule has changed anything. */
  get start(): Scenario | null {
    return this.info && atStart(this.info);
  }

  /** Target session of commands. */
  private get target(): string {
    if (this.missing !== '' || !this.info) throw new Error(this.missing);
    return this.info.id;
  }

  /** Time of the newest sample. */
  get time(): number {
    const ring = this.client?.ring;
    return ring && ring.end > ring.start ? ring.end * this.moments.period : (this.info?.time ?? 0);
  }

  /** Finds the session of the address or of the last visit, or makes one. */
  async open(): Promise<void> {
    try {
      await this.find();
    } catch (error) {
      if (!this.info) this.missing = `There is no session yet: ${reason(error)}.`;
      throw error;
    }
  }

  private async find(): Promise<void> {
    if (fromAddress('scenario') !== null && (await this.openLinked())) return;
    const id = fromAddress('session') ?? keptSessions()[0];
    if (id === undefined) await this.create({});
    else await this.show(id);
  }

  /** Shows a session as this browser left it; makes it again where the server no longer has it. */
  private async show(id: string): Promise<void> {
    const kept = recall(id);
    try {
      const info = await this.api.session(id);
      this.adopt(info, kept ?? { speed: info.speed });
    } catch (error) {
      if (!(error instanceof ApiError) || error.status !== 404) throw error;
      await this.recreate(kept);
    }
  }

  /** Shows a motion on drives; what the controls show stays, and is still the session's of before. */
  showMotion(motion: SessionInfo): void {
    if (!this.info || !this.base) return;
    if (this.home === '') [this.home, this.whole] = [this.id, this.info.scenario];
    const { base, draft, paths } = this;
    this.adopt(motion, { base, draft, paths });
  }

  /** Goes back from a motion on drives to the session that it was begun from. */
  async leaveMotion(): Promise<void> {
    if (this.home !== '') await this.show(this.home);
  }

  /** Makes the session that the address describes; false where that is damaged or refused. */
  private async openLinked(): Promise<boolean> {
    let opened = true;
    try {
      const { linkedSession } = await import('../lab-link');
      const { draft, ...request } = linkedSession();
      await this.create(request, { draft });
      const unfit = Object.keys(draft).filter((path) => !(path in this.draft));
      if (unfit.length > 0) messages.error(`Not staged, as it fits no field: ${unfit.join(', ')}.`);
    } catch (error) {
      if (error instanceof ApiError && error.transient) throw error;
      messages.error(`The link cannot be opened: ${reason(error)}.`);
      opened = false;
    }
    setAddress({ scenario: '', set: '', draft: '' });
    return opened;
  }

  /**
   * Makes a session, after those requested before; the present one ends. It starts without
   * what-if changes, at real time, unless `own` says otherwise.
   */
  create(request: ScenarioRequest, own: Partial<Own> = {}): Promise<void> {
    const made = this.making.then(() => this.make(request, own));
    const making = made.then(
      () => true,
      () => {
        // Commands that come later are for the session that is there.
        if (this.making === making) this.making = Promise.resolve(true);
        return false;
      },
    );
    this.making = making;
    return made;
  }

  /**
   * Waits for a session that is being made: a command given meanwhile is meant for that one. False
   * where it must not be carried out, as there is none, or STOP was pressed after it.
   */
  async settled(): Promise<boolean> {
    const { stops } = this;
    return (await this.making) && stops === this.stops && !this.halt.unsent;
  }

  /** Makes a session; the present one ends unless it has other viewers. */
  private async make(request: ScenarioRequest, own: Partial<Own>): Promise<void> {
    // A motion on drives is not ended by that.
    const before = this.home || this.id;
    const info = await this.api.create(request);
    const alone = before !== '' && (await this.alone(before).catch(() => false));
    this.adopt(info, own);
    if (!alone) return;
    forget(before);
    await this.api.remove(before).catch(() => undefined);
  }

  /** Whether the session has no other viewer. Asked while our own stream still counts. */
  private async alone(id: string): Promise<boolean> {
    const own = this.client?.connections ?? 0;
    const { watchers } = await this.api.session(id);
    return watchers <= own;
  }

  /** Asks for columns, and computes others from them. */
  subscribe(columns: readonly string[], computed: readonly Computed[] = []): void {
    this.subscription = columns;
    this.computed = computed;
    this.client?.compute(computed);
    this.client?.subscribe(this.streamed);
  }

  /** What there is of the subscription: a motion on drives has the channels of one variant. */
  private get streamed(): readonly string[] {
    const { variant } = this;
    if (variant === '') return this.subscription;
    return this.subscription.filter(
      (column) => /^[xy]\./.test(column) || column.startsWith(`${variant}.`),
    );
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

  /** Asks for the state of now, which the stream may bring later. */
  async refresh(): Promise<SessionInfo> {
    const info = await this.api.session(this.target);
    this.update(info);
    return info;
  }

  async undo(): Promise<void> {
    const last = this.info?.changes.at(-1);
    this.update(await this.api.command(this.target, 'undo'));
    if (!last || this.home === '') return;
    const before = Object.entries(last.previous) as [string, Value][];
    const changed = before.filter(([path, value]) => !equal(at(this.whole, path), value));
    const draft = without(this.draft, Object.keys(last.set));
    this.setDraft({ ...draft, ...Object.fromEntries(changed) });
  }

  async stop(): Promise<void> {
    this.toStop = [...this.toStop, this.target];
    this.stops += 1;
    await this.halt.press();
  }

  private async sendStop(signal: AbortSignal): Promise<void> {
    await Promise.all(this.toStop.map((id) => this.stopOne(id, signal)));
  }

  /** Throws where the server has not answered, or has refused. */
  private async stopOne(id: string, signal: AbortSignal): Promise<void> {
    try {
      this.update(await this.api.command(id, 'stop', {}, signal));
      this.toStop = this.toStop.filter((other) => other !== id);
    } catch (error) {
      if (RepeatedStop.unanswered(error)) throw error;
      this.toStop = this.toStop.filter((other) => other !== id);
      // One that has ended no longer moves, and the one in its place has not begun to.
      const gone = error instanceof ApiError && error.status === 404;
      if (id === this.id && !gone) throw error;
    }
  }

  /** Gives who uses this browser a name; '' for a guest. */
  rename(name: string): void {
    person.rename(name);
    this.client?.introduce(person.message);
  }

  async setSpeed(speed: number): Promise<void> {
    const within = Math.min(SPEED.most, Math.max(SPEED.least, speed));
    this.speed = Number(within.toPrecision(2));
    this.keep();
    if (this.info?.state === 'playing') await this.play();
  }

  async push(axis: Axis, force: number): Promise<void> {
    await this.api.push(this.target, { axis, force, duration: PUSH_SECONDS });
  }

  /** Takes other what-if changes. */
  setDraft(draft: Changes): void {
    this.draft = draft;
    if (this.id !== '') rememberDraft(this.home || this.id, draft);
  }

  /** Keeps the name of a what-if path. */
  namePath(path: GivenPath): void {
    this.paths = withPath(this.paths, path);
    this.keep();
  }

  /** Changes parameters of the running session; the server chooses the tick. */
  async patch(set: Changes): Promise<void> {
    const now = this.home === '' ? set : without(set, this.waiting(set));
    if (Object.keys(now).length > 0) await this.api.patch(this.target, now);
    // The stream brings the server's own account; until then the controls need not jump back.
    if (this.info) this.info = { ...this.info, scenario: withChanges(this.info.scenario, set) };
    // What was changed on drives is not lost on the way back: it waits there as what-if changes.
    if (this.home !== '') this.setDraft({ ...this.draft, ...set });
  }

  /** Paths of variants that do not move just now, after a stop of all: their next motion has them. */
  private waiting(set: Changes): string[] {
    const ofVariants = Object.keys(set).filter((path) => path.startsWith('variants.'));
    if (this.info?.state === 'stopped') return ofVariants;
    return ofVariants.filter((path) => !path.startsWith(`variants.${this.variant}.`));
  }

  private update(info: SessionInfo): void {
    if (info.id !== this.info?.id || info.revision < this.info.revision) return;
    const { period } = this.moments;
    const stop = newStop(this.info, info);
    const by = person.other(stop?.by);
    if (stop && by !== '' && period > 0) {
      const time = digits(stop.tick * period, 3);
      messages.info(`The session was stopped${by} at ${time} s.`, [], { stays: true });
    }
    const reset = newReset(this.info, info);
    if (person.other(reset?.by) !== '') {
      messages.info(`The session was reset${person.other(reset?.by)}.`);
    }
    const law = newLaw(this.info, info);
    if (law) messages.withdraw(this.lawProblem);
    if (law?.reason) {
      const text = lawText(law);
      this.lawProblem = `${text.charAt(0).toUpperCase()}${text.slice(1)}`;
      messages.error(this.lawProblem);
    } else if (law) {
      if (this.base) this.base = declaredAs(this.base, info.base);
      this.setDraft(fitting(this.draft, info.scenario));
      this.onLaw();
    }
    // The next Play goes on at the speed that another person has chosen.
    const latest = info.events.filter(({ speed }) => typeof speed === 'number').at(-1);
    const others = person.other(latest?.by) !== '';
    if (info.speed !== this.info.speed && others) this.speed = info.speed;
    this.moments.events = info.events;
    this.info = this.shown(info);
    this.keep();
  }

  private shown(info: SessionInfo): SessionInfo {
    if (!this.whole) return info;
    const scenario = withChanges(this.whole, this.draft);
    const variants = { ...scenario.variants };
    for (const [name, own] of Object.entries(info.scenario.variants)) {
      const shown = scenario.variants[name] ?? own;
      const { delay } = shown.controller; // on drives it is always 1
      variants[name] = { ...own, controller: { ...own.controller, delay } };
    }
    return { ...info, scenario: { ...scenario, variants } };
  }

  private adopt(info: SessionInfo, own: Partial<Own>): void {
    this.client?.close();
    if (info.id !== this.info?.id) person.enter();
    this.moments.events = info.events;
    if (!info.drive) [this.home, this.whole] = ['', null];
    this.variant = info.drive ? (Object.keys(info.scenario.variants)[0] ?? '') : '';
    this.info = this.shown(info);
    this.base = own.base ? declaredAs(own.base, info.base) : info.base;
    this.draft = fitting(own.draft ?? {}, info.scenario);
    this.paths = own.paths ?? [];
    this.speed = info.state === 'playing' ? info.speed : (own.speed ?? 1);
    this.missing = '';
    if (this.home === '') {
      setAddress({ session: info.id });
      this.keep();
      rememberDraft(info.id, this.draft);
    }
    // That of a demo has none: nothing moves.
    if (info.stream === '') return;
    const protocol = location.protocol === 'https:' ? 'wss' : 'ws';
    this.client = new StreamClient(
      `${protocol}://${location.host}${info.stream}`,
      {
        connection: (state) => (this.connection = state),
        rate: (rate) => (this.moments.period = 1 / rate),
        channels: (channels) => (this.channels = channels),
        session: (news) => this.update(news),
        named: (name) => person.take(name),
        reset: () => undefined,
        problem: (detail) => messages.error(detail),
      },
      { seconds: KEPT, alive: () => this.alive(info.id) },
    );
    this.client.compute(this.computed);
    this.client.subscribe(this.streamed);
    this.client.introduce(person.message);
    this.client.connect();
  }

  private keep(): void {
    const { id, start, base, paths, speed } = this;
    if (start && base && this.home === '') remember({ id, scenario: start, base, paths, speed });
  }

  /** Whether the session is still there; makes it again when the server has lost it. */
  private async alive(id: string): Promise<boolean> {
    try {
      this.update(await this.api.session(id, AbortSignal.timeout(PATIENCE)));
      return true;
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      if (error.status === 404 && id === this.info?.id) {
        const { base, start, draft, paths, speed } = this;
        const kept = base && start && { id, scenario: start, base, draft, paths, speed };
        await this.recreate(kept).catch((failure) => {
          const silent = failure instanceof ApiError && failure.status === UNREACHABLE;
          if (!silent) messages.error(this.missing);
        });
      } else if (!error.transient) {
        messages.error(error.message);
      }
      return false;
    }
  }

  /**
   * Makes a session in place of one that the server no longer has. Until that succeeds the page goes
   * on showing the lost one, and commands are refused with the reason.
   */
  private async recreate(kept: Kept | null): Promise<void> {
    this.missing = 'The server no longer has this session, and it is being made again.';
    try {
      await this.remake(kept);
    } catch (error) {
      this.missing =
        'The server no longer has this session, and could not yet make it again: ' +
        `${reason(error)}. The page keeps trying.`;
      throw error;
    }
  }

  private async remake(kept: Kept | null): Promise<void> {
    if (!kept) {
      await this.create({});
      messages.info('The session of this address no longer exists. A new one was made.');
      return;
    }
    try {
      await this.create({ scenario: kept.scenario }, kept);
      forget(kept.id);
    } catch (error) {
      if (!(error instanceof ApiError) || error.status !== 422) throw error;
      // What an older version or a damaged storage has kept must not keep the page from opening.
      await this.create({});
      messages.error(`The session was gone, and what was kept of it is refused. ${error.message}`);
      return;
    }
    messages.info(
      'The session was gone: another tab has left it, the server was restarted, or it had been idle ' +
        'for long. It was made again from the scenario and the changes kept here, and is paused at ' +
        '0 s. Undo begins anew: changes made before stay.',
      [],
      { stays: true },
    );
  }
}
