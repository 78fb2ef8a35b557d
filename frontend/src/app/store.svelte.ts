/** The application store: scenario, session and what-if changes, and what all screens do with them. */

import { TokenPrompt } from './api/access-token.svelte';
import { Api, ApiError, UNREACHABLE } from './api/client';
import {
  at,
  changedPaths,
  difference,
  equal,
  needsRestart,
  ofTrajectory,
  withChanges,
  without,
} from './api/scenario-paths';
import type {
  Changes,
  Metrics,
  Parts,
  ProblemField,
  Scenario,
  ScenarioEntry,
  Value,
} from './api/types';
import { fileErrorText, errorText } from './error-text';
import { refusal } from './fields/fields';
import { LatestWins } from './latest-wins';
import { messages, type Action } from './messages.svelte';
import { Gestures, is } from './session/gestures';
import { keptSessions, recall, withPath, type GivenPath } from './session/kept-sessions';
import { pathName } from './session/path-name';
import { carried, leftText, listed, lost, type Left } from './session/replaced-session';
import { SessionStore } from './session/session.svelte';
import { fromAddress, load, save, setAddress } from './storage';
import { Backoff } from './stream/backoff';
import { WhatIf } from './whatif/whatif.svelte';

export type Mode = 'whatif' | 'live';

/** Sessions that Undo can go back to. */
const BACK_MAX = 20;

/** Shortest time between two changes of a running session while a slider moves, ms. */
const LIVE_SPACING = 80;

export class Store {
  readonly api = new Api();
  readonly token = new TokenPrompt(this.api);
  readonly session = new SessionStore(this.api);
  readonly whatif = new WhatIf(this.api, (fields, detail) => this.refuse(fields, detail));
  scenarios = $state.raw<readonly ScenarioEntry[]>([]);
  parts = $state.raw<Parts>({ motors: [], controllers: [], trajectories: [] });
  mode = $state<Mode>(
    (fromAddress('mode') ?? load('mode', 'whatif')) === 'live' ? 'live' : 'whatif',
  );
  /** Messages of refused values, by path. */
  problems = $state.raw<Record<string, string>>({});
  /** What stands in fields and is no number, by path; empty while it is typed. */
  mistyped = $state.raw<Record<string, string>>({});
  metrics = $state.raw<Metrics | null>(null);
  /** The shipped scenario of the same name, where the paper's values stand. */
  shipped = $state.raw<Scenario | null>(null);
  private drafts = $state.raw<readonly Changes[]>([]);
  /** What sessions took the place of, the oldest first: Undo goes back to the last one. */
  private left = $state.raw<readonly Left[]>([]);
  /** The what-if changes that the session was given last: undone, they are what-if changes again. */
  private applied = $state.raw<Pick<Left, 'draft' | 'drafts'> | null>(null);
  /** What shipped parts consist of, as `path=name`. */
  resolved = $state.raw<Readonly<Record<string, Value>>>({});
  /** Live changes that the server has not confirmed. */
  private unsent = $state.raw<Changes>({});
  private readonly gestures = new Gestures();
  /** Ends when all is taken back that was asked for; nothing is sent meanwhile. */
  private undoing = Promise.resolve();
  private moving = false;
  private readonly live = new LatestWins<null>(() => this.sendLive());
  private readonly reading = new LatestWins<null>(() => this.askMetrics());

  /** What the controls show. */
  readonly scenario = $derived.by((): Scenario | null => {
    const current = this.session.info?.scenario;
    if (!current) return null;
    return withChanges(current, this.mode === 'whatif' ? this.draft : this.unsent, this.resolved);
  });

  private readonly letters = $derived(
    Object.keys(this.session.info?.scenario.variants ?? {}).join(' '),
  );

  /** A new list only when it has other names: what is drawn for each would begin anew. */
  readonly variants = $derived(this.letters === '' ? [] : this.letters.split(' '));

  /** How what the controls show differs from the scenario as it was loaded. */
  readonly changes = $derived(
    this.scenario && this.session.base ? difference(this.session.base, this.scenario) : [],
  );

  readonly pending = $derived(Object.keys(this.draft).length);

  /** What the path is called that the controls show, where it is not the scenario's own. */
  readonly pathName = $derived(
    pathName(this.scenario?.trajectory, this.session.base?.trajectory, this.session.paths),
  );

  /** The session's last change; the server's account of it may come later. */
  private readonly lastChange = $derived(this.session.info?.changes.at(-1));

  /** Whether the session's last change gave it the what-if changes. */
  private readonly undoesApply = $derived(
    this.applied !== null &&
      this.lastChange !== undefined &&
      is(this.lastChange, this.applied.draft),
  );

  /** Whether what-if has a gesture to take back, before all that was done to the session. */
  private readonly undoesDraft = $derived(this.mode === 'whatif' && this.drafts.length > 0);

  /** Whether Undo goes back to the session before this one, in which nothing was changed yet. */
  readonly goesBack = $derived(
    this.left.length > 0 && !this.undoesDraft && this.session.info?.changes.length === 0,
  );

  /** What Undo will do; empty where there is nothing to take back. */
  readonly undoText = $derived.by((): string => {
    if (this.undoesDraft) {
      return `Take back the what-if change of ${listed(changedPaths(this.drafts.at(-1) ?? {}, this.draft))}`;
    }
    if (this.goesBack)
      return `Go back to the session before, ${this.left.at(-1)?.scenario.name}, at 0 s`;
    if (this.mode === 'whatif' && !this.undoesApply) return '';
    if (!this.lastChange) return '';
    const what = listed(Object.keys(this.lastChange.set));
    return this.undoesApply ? `Take back Apply: ${what}` : `Take back the change of ${what}`;
  });

  readonly canUndo = $derived(this.undoText !== '');

  /** What-if changes that the session does not have. */
  get draft(): Changes {
    return this.session.draft;
  }

  /** Loads lists and session; a server that is busy or out of reach is asked again until it answers. */
  async start(): Promise<void> {
    void this.try(() => this.token.start());
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

  private async open(): Promise<void> {
    [this.scenarios, this.parts] = await Promise.all([this.api.scenarios(), this.api.parts()]);
    const [last] = keptSessions();
    if (!this.session.info) await this.session.open();
    await this.afterLoad();
    if (last !== undefined) this.tellOfDraft(last);
    const motor = this.draft.plant;
    if (typeof motor === 'string') await this.resolve('plant', motor);
  }

  /** Runs something that talks to the server; a failure becomes a message. Whether it succeeded. */
  async try(action: () => Promise<void>): Promise<boolean> {
    try {
      await action();
      return true;
    } catch (error) {
      messages.error(errorText(error));
      return false;
    }
  }

  setMode(mode: Mode): void {
    this.mode = mode;
    this.problems = {};
    save('mode', mode);
    setAddress({ mode });
  }

  /** Takes the value of a control; `moving` while it has not been let go of. */
  set(changes: Changes, moving = false): void {
    const begins = !this.moving;
    this.moving = moving;
    this.problems = without(this.problems, Object.keys(changes));
    if (this.mode === 'whatif') this.setDraft(changes, begins);
    else this.setLive(changes, begins);
  }

  /** Takes what stands in a field in place of its value; null when it is gone. */
  mistype(path: string, text: string | null): void {
    const others = without(this.mistyped, [path]);
    this.mistyped = text === null ? others : { ...others, [path]: text };
  }

  async playOrPause(): Promise<void> {
    if (!(await this.session.settled())) return;
    if (this.session.info?.state === 'playing') await this.try(() => this.session.pause());
    else await this.play({ changed: true });
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
    });
  }

  async step(ticks: number): Promise<void> {
    if (!(await this.session.settled())) return;
    this.setMode('live');
    await this.try(() => this.session.step(ticks));
  }

  async reset(): Promise<void> {
    if (!(await this.session.settled())) return;
    await this.try(() => this.session.reset());
  }

  /** Stops at once: nothing is asked and nothing is waited for. */
  async stop(): Promise<void> {
    try {
      await this.session.stop();
    } catch (error) {
      messages.error(`STOP was not taken. ${errorText(error)}`);
    }
  }

  async choosePlant(name: string): Promise<void> {
    await this.try(async () => {
      await this.resolve('plant', name);
      const inside = Object.keys(this.draft).filter((path) => path.startsWith('plant.'));
      if (inside.length > 0) this.forget(inside);
      this.set({ plant: name });
    });
  }

  /** Takes a whole path as a what-if change, in place of changes of the present one. */
  tryPath(path: GivenPath): void {
    const others = Object.entries(this.draft).filter(([key]) => !ofTrajectory(key));
    this.setMode('whatif');
    this.drafts = [...this.drafts, this.draft];
    this.keepDraft({ ...Object.fromEntries(others), trajectory: path.table as Value });
    this.session.namePath(path);
  }

  /** Gives a whole path to the session, which begins anew at 0 s with all gains and what-if changes. */
  async givePath(path: GivenPath): Promise<void> {
    await this.try(async () => {
      await this.give({ trajectory: path.table as Value }, path);
      this.forget(Object.keys(this.draft).filter(ofTrajectory));
      this.setMode('live');
    });
  }

  async undo(): Promise<void> {
    if (this.goesBack) {
      await this.try(async () => {
        // A change may have been made that the server has not told of yet.
        while (this.live.busy) await this.live.idle();
        await this.session.refresh();
      });
      if (this.goesBack) {
        await this.goBack();
        return;
      }
    }
    if (this.undoesDraft) {
      this.keepDraft(this.drafts.at(-1) ?? {});
      this.drafts = this.drafts.slice(0, -1);
    } else if (this.mode === 'live' || this.undoesApply) {
      await this.try(() => this.undoLive());
    }
  }

  /** Takes the last gesture back, once all of it has been sent. */
  private async undoLive(): Promise<void> {
    await this.undoing;
    while (this.live.busy) await this.live.idle();
    const undone = (async () => {
      const { changes } = await this.session.refresh();
      const { applied, undoesApply } = this;
      const steps = Math.min(changes.length, this.gestures.take(changes));
      for (let i = 0; i < steps; i++) await this.session.undo();
      if (!applied || !undoesApply) return;
      this.applied = null;
      this.drafts = [...applied.drafts, ...this.drafts];
      this.keepDraft({ ...applied.draft, ...this.draft });
    })();
    this.undoing = undone.catch(() => undefined);
    await undone;
  }

  discard(): void {
    this.drafts = [...this.drafts, this.draft];
    this.keepDraft({});
  }

  /** Gives what-if changes to the session: at its next tick, or from 0 s where they need that. */
  async apply(): Promise<boolean> {
    return this.try(async () => {
      const { draft, drafts } = this;
      await this.give(draft);
      this.applied = { draft, drafts };
      this.drafts = [];
      this.keepDraft({});
    });
  }

  /**
   * Opens a scenario in place of the present one, with changes if there are any. Gains and what-if
   * changes stay behind with the one before: a notice says so, and offers the way back.
   */
  async loadScenario(scenario: string | Scenario, set: Changes = {}): Promise<void> {
    await this.try(async () => {
      const left = this.whatIsHere();
      await this.session.create({ scenario, set });
      this.drafts = [];
      await this.afterLoad();
      if (!left || lost(left).length === 0) return;
      this.left = [...this.left.slice(1 - BACK_MAX), left];
      this.tellOfLeft(left);
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

  /** Goes back to what a session took the place of, at 0 s, unless that has been done already. */
  private async goBack(left = this.left.at(-1)): Promise<void> {
    if (!left || !this.left.includes(left)) return;
    await this.try(async () => {
      await this.session.create({ scenario: left.scenario }, left);
      this.left = this.left.slice(0, this.left.indexOf(left));
      this.drafts = left.drafts;
      await this.afterLoad();
      this.setMode(left.mode);
    });
  }

  private wayBack(left: Left): Action {
    return { name: 'Undo', run: () => void this.goBack(left) };
  }

  private whatIsHere(): Left | null {
    const { start, base, draft, paths, speed } = this.session;
    const { mode, drafts } = this;
    return start && base && { scenario: start, base, draft, drafts, paths, speed, mode };
  }

  private tellOfLeft(left: Left): void {
    const keep = {
      name: 'Keep the gains',
      run: () => {
        this.setMode('whatif');
        // Another scenario may have been chosen since.
        this.set(carried(left, this.scenario));
      },
    };
    const some = Object.keys(carried(left, this.scenario)).length > 0;
    messages.info(leftText(left), some ? [this.wayBack(left), keep] : [this.wayBack(left)]);
  }

  /** Says where what-if changes wait, when the address has opened another session than the last. */
  private tellOfDraft(last: string): void {
    const waiting = recall(last);
    const count = Object.keys(waiting?.draft ?? {}).length;
    if (!waiting || last === this.session.id || count === 0) return;
    const back = { name: 'Go back', run: () => location.assign(`?session=${last}`) };
    const changes = count === 1 ? 'One what-if change waits' : `${count} what-if changes wait`;
    messages.info(`${changes} in the session before, ${waiting.scenario.name}.`, [back]);
  }

  /** Asks for the metrics of now; one question at a time, so that the newest answer stays. */
  readMetrics(): void {
    this.reading.push(null);
  }

  private async askMetrics(): Promise<void> {
    const { id } = this.session;
    // Before the first tick there is nothing to measure.
    if (id === '' || this.session.time === 0) {
      this.metrics = null;
      return;
    }
    try {
      const metrics = await this.api.metrics(id);
      if (id !== this.session.id) return;
      this.metrics = Object.keys(metrics.variants).length > 0 ? metrics : null;
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      // Too early for a window. Without a server, what was measured last stays.
      if (error.status !== UNREACHABLE) this.metrics = null;
    }
  }

  private setDraft(changes: Changes, begins: boolean): void {
    if (begins) this.drafts = [...this.drafts, this.draft];
    // What lay inside a part goes with the part.
    const replaced = Object.keys(changes).map((path) => `${path}.`);
    const kept = Object.entries(this.draft).filter(
      ([path]) => !replaced.some((part) => path.startsWith(part)),
    );
    const draft = { ...Object.fromEntries(kept), ...changes };
    const current = this.session.info?.scenario ?? null;
    for (const [path, value] of Object.entries(draft)) {
      const now = path === 'plant' ? at(current, 'plant.name') : at(current, path);
      if (equal(now, value) && !(`plant` in draft && path.startsWith('plant.'))) {
        Reflect.deleteProperty(draft, path);
      }
    }
    this.keepDraft(draft);
  }

  private setLive(changes: Changes, begins: boolean): void {
    this.gestures.put(changes, begins);
    this.unsent = this.gestures.unsent;
    this.live.push(null);
  }

  private async sendLive(): Promise<void> {
    await this.undoing;
    const sending = this.gestures.next();
    if (!sending) return;
    try {
      await this.give(sending.set);
      sending.taken();
    } catch (error) {
      if (error instanceof ApiError) this.refuse(error.problem.errors, error.message);
      else throw error;
    } finally {
      sending.done();
      this.unsent = this.gestures.unsent;
    }
    await new Promise((resolve) => setTimeout(resolve, LIVE_SPACING));
    if (this.gestures.next()) this.live.push(null);
  }

  private async give(set: Changes, path: GivenPath | null = null): Promise<void> {
    await this.session.settled();
    const left = this.whatIsHere();
    if (!left) return;
    if (Object.keys(set).some(needsRestart)) {
      const paths = path ? withPath(left.paths, path) : left.paths;
      await this.session.create({ scenario: left.scenario, set }, { ...left, paths });
      this.gestures.clear();
      this.applied = null;
      this.left = [...this.left.slice(1 - BACK_MAX), left];
      const what = path
        ? `The session took ${path.name || 'the drawn path'} and`
        : 'Trajectory and seed hold from the start: the session';
      messages.info(`${what} went back to 0 s.`, [this.wayBack(left)]);
    } else {
      await this.session.patch(set);
    }
  }

  private forget(paths: readonly string[]): void {
    this.keepDraft(without(this.draft, paths));
  }

  private keepDraft(draft: Changes): void {
    this.session.setDraft(draft);
  }

  /** Looks up what a shipped part consists of, so that the controls can show it. */
  private async resolve(path: 'plant', name: string): Promise<void> {
    const key = `${path}=${name}`;
    if (key in this.resolved) return;
    const scenario = await this.api.parse(`base = "circle"\n${path} = "${name}"\n`);
    this.resolved = { ...this.resolved, [key]: scenario[path] };
  }

  private async afterLoad(): Promise<void> {
    this.gestures.clear();
    this.applied = null;
    this.metrics = null;
    const name = this.session.info?.scenario.name ?? '';
    const known = this.scenarios.some((entry) => entry.name === name);
    this.shipped = known ? await this.api.scenario(name) : null;
  }

  private refuse(fields: readonly ProblemField[], detail: string): void {
    const problems = Object.fromEntries(fields.map((field) => [field.loc, refusal(field)]));
    this.problems = problems;
    if (fields.length === 0 && detail !== '') messages.error(detail);
  }
}

export const app = new Store();
