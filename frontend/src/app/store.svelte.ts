/** The application store: scenario, session and what-if changes, and what all screens do with them. */

import { Api, ApiError, UNREACHABLE } from './api/client';
import { difference, ofTrajectory, withChanges } from './api/scenario-paths';
import type { Changes, Metrics, Scenario, Value } from './api/types';
import { Catalogue } from './catalogue.svelte';
import { DriveLink } from './drive/drive-link.svelte';
import { demo, NEEDS_SERVER } from './demo/demo-mode';
import { PATIENCE } from './whatif/loading';
import { commandText, errorText, fileErrorText } from './error-text';
import { Expressions } from './expressions/expressions.svelte';
import { needsRestart, Refusals } from './fields/fields.svelte';
import { type Action, messages } from './messages.svelte';
import { LiveChanges, LiveMetrics } from './session/live-changes.svelte';
import { Draft } from './session/draft.svelte';
import { type GivenPath, keptSessions, pathName, recall, withPath } from './session/kept-sessions';
import {
  carriedGains,
  lostPaths,
  type ReplacedSession,
  replacedText,
} from './session/replaced-session';
import { screen } from './screen.svelte';
import { SessionStore } from './session/session.svelte';
import { fromAddress, load, save, setAddress } from './storage';
import { Backoff } from './stream/stream-client';
import { LinkWatch, type Watched } from './stream/link-watch.svelte';
import { Undo } from './undo.svelte';
import { LaneChanges } from './whatif/lane-changes';
import { PageKernel } from './whatif/page-kernel';
import { WhatIf } from './whatif/whatif.svelte';

/** So often the server is asked whether it still compiles, ms. */
const COMPILATION = 1000;

export type Mode = 'whatif' | 'live';

export class Store {
  readonly api = new Api();
  readonly token = new TokenPrompt(this.api);
  readonly catalogue = new Catalogue(this.api);
  readonly drive = new DriveLink(this.api);
  readonly session = new SessionStore(this.api);
  readonly expressions = new Expressions(this.api);
  readonly metrics = new LiveMetrics(this.api, this.session);
  readonly refusals = new Refusals();
  /** The kernel in the page, which what-ifs share. */
  readonly kernel = new PageKernel(
    new LaneChanges(() => this.catalogue.resolved),
    undefined,
    demo === null ? PATIENCE : Number.POSITIVE_INFINITY, // a demo has no server to compute instead
  );
  readonly whatif = new WhatIf(
    this.api,
    (fields, detail) => this.refusals.take(fields, detail),
    this.kernel,
    demo !== null,
  );
  mode = $state<Mode>(
    demo === null && (fromAddress('mode') ?? load('mode', 'whatif')) === 'live' ? 'live' : 'whatif',
  );
  /** The draft with its history. */
  readonly whatIfChanges = new Draft(this.session);
  private readonly live = new LiveChanges(
    (set) => this.give(set),
    (fields, detail) => this.refusals.take(fields, detail),
  );
  readonly undo = new Undo(this, this.live);
  readonly link = new LinkWatch(this.watched());
  /** Whether the server compiles what simulations need, once on its machine. */
  compiling = $state(false);
  /** Share of what the server compiles that is compiled, 0 to 1. */
  compiledShare = $state(1);
  /** What a gesture that goes on changes; empty while none does. */
  private gesture = '';

  /** What the controls show. */
  readonly scenario = $derived.by((): Scenario | null => {
    const current = this.session.info?.scenario;
    if (!current) return null;
    const changes = this.mode === 'whatif' ? this.draft : this.live.unsent;
    return withChanges(current, changes, this.catalogue.resolved);
  });

  private applying: Promise<boolean> | null = null;
  private readonly letters = $derived(
    Object.keys(this.session.info?.scenario.variants ?? {}).join(' '),
  );

  /** A new list only when it has other names: what is drawn for each would begin anew. */
  readonly variants = $derived(this.letters === '' ? [] : this.letters.split(' '));

  /** Differences of the controls from the scenario as it was loaded. */
  readonly changes = $derived(
    this.scenario && this.session.base ? difference(this.session.base, this.scenario) : [],
  );

  readonly pending = $derived(Object.keys(this.draft).length);

  /** Name of the controls' path, if it is not the scenario's own. */
  readonly pathName = $derived(
    pathName(this.scenario?.trajectory, this.session.base?.trajectory, this.session.paths),
  );

  /** What-if changes that the session does not have. */
  get draft(): Changes {
    return this.session.draft;
  }

  constructor() {
    this.session.onLaw = () => {
      const name = this.session.info?.scenario.name ?? '';
      void this.try(() => this.catalogue.lawsChanged(name));
    };
  }

  /** Loads lists and session; requests to a busy or unreachable server are repeated. */
  async start(): Promise<void> {
    if (this.mode === 'whatif') this.kernel.warm();
    const backoff = new Backoff();
    for (;;) {
      try {
        await this.open();
        return;
      } catch (error) {
        messages.error(errorText(error));
        if (!(error instanceof ApiError) || !error.transient) return;
        const wait = error.retryAfter ?? backoff.next();
        await new Promise((resolve) => setTimeout(resolve, wait));
      }
    }
  }

  /** Asks what the server is. */
  private async meet(): Promise<void> {
    const { login, drive, help, compiling, compiled_share } = await this.api.health();
    screen.documented = help;
    this.token.required = login;
    this.drive.start(drive);
    this.compiling = compiling;
    this.compiledShare = compiled_share;
    if (compiling) void this.watchCompilation();
  }

  /** Asks until the server has compiled what simulations need. */
  private async watchCompilation(): Promise<void> {
    while (this.compiling) {
      await new Promise((resolve) => setTimeout(resolve, COMPILATION));
      const health = await this.api.health().catch(() => null);
      this.compiling = health?.compiling ?? true;
      this.compiledShare = health?.compiled_share ?? this.compiledShare;
    }
  }

  private async open(): Promise<void> {
    await Promise.all([this.meet(), this.catalogue.load()]);
    const [last] = keptSessions();
    if (!this.session.info) await this.session.open();
    await this.afterLoad();
    if (last !== undefined) this.tellOfDraft(last);
    const motor = this.draft.plant;
    if (typeof motor === 'string') await this.catalogue.resolvePlant(motor);
  }

  /**
   * Runs something that talks to the server; a failure becomes a message. Whether it succeeded. A
   * `command` is named where there is no answer.
   */
  async try(action: () => Promise<void>, command = ''): Promise<boolean> {
    try {
      await action();
      return true;
    } catch (error) {
      messages.error(command === '' ? errorText(error) : commandText(command, error));
      return false;
    }
  }

  /** Whether STOP was pressed and nothing has answered it. */
  get stopUnsent(): boolean {
    return this.session.halt.unsent || this.drive.halt.unsent;
  }

  /** Watches the link to the server until the returned function is called. */
  watch(): () => void {
    const hurry = (): void => {
      this.session.halt.hurry();
      this.drive.halt.hurry();
    };
    addEventListener('online', hurry);
    const end = this.link.start();
    return () => {
      end();
      removeEventListener('online', hurry);
    };
  }

  /** What must come without end, and how to ask where it does not. */
  private watched(): Watched {
    const { session, api } = this;
    return {
      get heardAt() {
        return session.client?.heardAt ?? null;
      },
      // On drives curves begin late and end early: there the drive link has an age of its own.
      get moving() {
        const { state = '', drive = '' } = session.info ?? {};
        return drive === '' && ['playing', 'stopping'].includes(state);
      },
      ask: () =>
        api.health(AbortSignal.timeout(1000)).catch((error: unknown) => {
          if (error instanceof ApiError && error.status === UNREACHABLE) throw error;
        }),
      reconnect: () => session.client?.reconnect(),
    };
  }

  setMode(mode: Mode): void {
    if (demo !== null && mode === 'live') {
      messages.info(NEEDS_SERVER);
      return;
    }
    this.mode = mode;
    this.refusals.clear();
    save('mode', mode);
    setAddress({ mode });
  }

  /** Takes the value of a control; `moving` while it is held, until `rest` or a value that is not. */
  set(changes: Changes, moving = false): void {
    const paths = Object.keys(changes).join();
    const begins = this.gesture !== paths;
    this.gesture = moving ? paths : '';
    this.refusals.clear(Object.keys(changes));
    if (this.mode === 'whatif') this.whatIfChanges.put(changes, begins);
    else this.live.put(changes, begins);
  }

  /** Ends the gesture that goes on: what comes next is taken back by itself. */
  rest(): void {
    this.gesture = '';
  }

  /** Plays with the what-if changes, but not with those that were taken back; or pauses. */
  async playOrPause(): Promise<void> {
    if (!(await this.session.settled())) return;
    if (this.session.info?.state === 'playing') await this.try(() => this.session.pause(), 'Pause');
    else await this.play({ changed: !this.whatIfChanges.takenBack });
  }

  /**
   * Plays, from 0 s where the session has finished: `changed` with the what-if changes, which are
   * given to the session first; else they stay where they are.
   */
  async play({ changed }: { changed: boolean }): Promise<void> {
    const { session } = this;
    if (!(await session.settled())) return;
    if (changed && this.pending > 0 && !(await this.apply())) return;
    this.setMode('live');
    await this.try(async () => {
      if (session.info?.state === 'finished') await session.reset();
      await session.play();
    }, 'Play');
  }

  async step(ticks: number): Promise<void> {
    if (!(await this.session.settled())) return;
    this.setMode('live');
    await this.try(() => this.session.step(ticks), 'Step');
  }

  async reset(): Promise<void> {
    if (!(await this.session.settled())) return;
    await this.try(() => this.session.reset(), 'Reset');
  }

  /** Stops at once, without confirmation: drives, and the session. Sent until it is answered. */
  async stop(): Promise<void> {
    await Promise.all([
      this.drive.stop().catch((error: unknown) => {
        messages.error(`The drives did not take STOP: use the emergency stop. ${errorText(error)}`);
      }),
      this.session.stop().catch((error: unknown) => {
        messages.error(`STOP was not taken. ${errorText(error)}`);
      }),
    ]);
  }

  async choosePlant(name: string): Promise<void> {
    await this.try(async () => {
      await this.catalogue.resolvePlant(name);
      const inside = Object.keys(this.draft).filter((path) => path.startsWith('plant.'));
      if (inside.length > 0) this.whatIfChanges.forget(inside);
      this.set({ plant: name });
    });
  }

  /** Takes a whole path as a what-if change, in place of changes of the present one. */
  tryPath(path: GivenPath): void {
    const others = Object.entries(this.draft).filter(([key]) => !ofTrajectory(key));
    this.setMode('whatif');
    const trajectory = path.table as Value;
    this.whatIfChanges.replace({ ...Object.fromEntries(others), trajectory });
    this.session.namePath(path);
  }

  /** Gives a whole path to the session, which begins anew at 0 s with all gains and what-if changes. */
  async givePath(path: GivenPath): Promise<void> {
    await this.try(async () => {
      await this.give({ trajectory: path.table as Value }, path);
      this.whatIfChanges.forget(Object.keys(this.draft).filter(ofTrajectory));
      this.setMode('live');
    });
  }

  discard(): void {
    this.rest();
    this.whatIfChanges.replace({});
  }

  /**
   * Gives what-if changes to the session: at its next tick, or from 0 s where they need that. Asked
   * for again meanwhile, as by a double click, it is done once.
   */
  apply(): Promise<boolean> {
    this.applying ??= this.giveStaged().finally(() => (this.applying = null));
    return this.applying;
  }

  private giveStaged(): Promise<boolean> {
    return this.try(async () => {
      const { draft } = this;
      const { history } = this.whatIfChanges;
      await this.give(draft);
      this.undo.noteApplied(draft, history);
      this.whatIfChanges.clear();
    });
  }

  /**
   * Opens a scenario in place of the present one, with changes if there are any. Gains and what-if
   * changes stay behind with the one before: a notice says so, and offers the way back.
   */
  async loadScenario(scenario: string | Scenario, set: Changes = {}): Promise<void> {
    await this.try(async () => {
      const before = this.whatIsHere();
      await this.session.create({ scenario, set });
      this.whatIfChanges.history = [];
      await this.afterLoad();
      if (!before || lostPaths(before).length === 0) return;
      this.tellOfReplaced(before, this.undo.noteReplaced(before));
    });
  }

  async upload(file: File): Promise<void> {
    let scenario: Scenario;
    try {
      scenario = await this.api.parse(await file.text());
    } catch (error) {
      messages.error(fileErrorText(file.name, error));
      return;
    }
    await this.loadScenario(scenario);
  }

  private whatIsHere(): ReplacedSession | null {
    const { start, base, draft, paths, speed } = this.session;
    const drafts = this.whatIfChanges.history;
    return start && base && { scenario: start, base, draft, drafts, paths, speed, mode: this.mode };
  }

  private tellOfReplaced(before: ReplacedSession, wayBack: Action): void {
    const keep = {
      name: 'Keep the gains',
      run: () => {
        this.setMode('whatif');
        // Another scenario may have been chosen since.
        this.set(carriedGains(before, this.scenario));
      },
    };
    const some = Object.keys(carriedGains(before, this.scenario)).length > 0;
    messages.info(replacedText(before), some ? [wayBack, keep] : [wayBack]);
  }

  /** Says where what-if changes wait, when the address has opened another session than the last. */
  private tellOfDraft(last: string): void {
    const waiting = recall(last);
    const count = Object.keys(waiting?.draft ?? {}).length;
    if (!waiting || last === this.session.id || count === 0) return;
    const back = { name: 'Go back', run: () => location.assign(`?session=${last}`) };
    const changes = count === 1 ? 'One staged change waits' : `${count} staged changes wait`;
    messages.info(`${changes} in the session before, ${waiting.scenario.name}.`, [back]);
  }

  private async give(set: Changes, path: GivenPath | null = null): Promise<void> {
    await this.session.settled();
    const before = this.whatIsHere();
    if (!before) return;
    if (Object.keys(set).some(needsRestart)) {
      const paths = path ? withPath(before.paths, path) : before.paths;
      await this.session.create({ scenario: before.scenario, set }, { ...before, paths });
      this.undo.clear();
      const what = path
        ? `The session took ${path.name || 'the drawn path'} and`
        : 'Trajectory, seed and learnt force hold from the start: the session';
      messages.info(`${what} went back to 0 s.`, [this.undo.noteReplaced(before)]);
    } else {
      await this.session.patch(set);
    }
  }

  /** Takes what belongs to another session. */
  async afterLoad(earlier: Metrics['variants'] = {}): Promise<void> {
    this.undo.clear();
    this.metrics.clear(earlier);
    await this.catalogue.loadShipped(this.session.info?.scenario.name ?? '');
  }
}

export class TokenPrompt {
  needed = $state(false);
  /** Whether this server has browsers log in at all. */
  required = $state(false);
  private waiting: (() => void)[] = [];

  constructor(private readonly api: Api) {
    api.onUnauthorized = () =>
      new Promise((resolve) => {
        this.needed = true;
        this.waiting.push(resolve);
      });
  }

  async give(token: string): Promise<void> {
    await this.api.login(token);
    this.needed = false;
    this.waiting.forEach((go) => go());
    this.waiting = [];
  }

  /** Ends the log-in; the page, loaded anew, asks for the token. */
  async end(): Promise<void> {
    await this.api.logout();
    location.reload();
  }
}

export const app = new Store();
