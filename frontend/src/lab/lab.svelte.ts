/** What the Lab screen knows and does; components read it and call it. */

import { Api, ApiError, UNREACHABLE } from '../api/client';
import { TokenPrompt } from '../api/token.svelte';
import { difference, equal, needsRestart, withChanges, at } from '../api/paths';
import type {
  Changes,
  Metrics,
  Parts,
  ProblemField,
  Scenario,
  ScenarioEntry,
  Trajectory,
  Value,
} from '../api/types';
import { refusal } from '../tuning/fields';
import { Limits } from '../tuning/limits.svelte';
import { Newest } from '../tuning/newest';
import { WhatIf } from '../tuning/whatif.svelte';
import { messages } from '../ui/messages.svelte';
import { fromAddress, load, save, setAddress } from '../ui/storage';
import { wordsOf } from '../ui/words';
import { SessionStore } from './session.svelte';

export type Mode = 'whatif' | 'live';

/** Shortest time between two changes of a running session while a slider moves, ms. */
const LIVE_SPACING = 80;

function ofTrajectory(path: string): boolean {
  return path.split('.')[0] === 'trajectory';
}

export class Lab {
  readonly api = new Api();
  readonly token = new TokenPrompt(this.api);
  readonly session = new SessionStore(this.api);
  readonly whatif = new WhatIf(this.api, (fields, detail) => this.refuse(fields, detail));
  readonly limits = new Limits(this.api);
  scenarios = $state.raw<readonly ScenarioEntry[]>([]);
  parts = $state.raw<Parts>({ motors: [], controllers: [], trajectories: [] });
  mode = $state<Mode>(
    (fromAddress('mode') ?? load('mode', 'whatif')) === 'live' ? 'live' : 'whatif',
  );
  /** What-if changes that the session does not have. */
  draft = $state.raw<Changes>(load('draft', {}));
  /** Messages of refused values, by path. */
  problems = $state.raw<Record<string, string>>({});
  metrics = $state.raw<Metrics | null>(null);
  /** The shipped scenario of the same name, where the paper's values stand. */
  shipped = $state.raw<Scenario | null>(null);
  private drafts = $state.raw<readonly Changes[]>([]);
  /** What shipped parts consist of, as `path=name`. */
  resolved = $state.raw<Readonly<Record<string, Value>>>({});
  /** Live changes that the server has not confirmed. */
  private unsent = $state.raw<Changes>({});
  /** How many changes each gesture has made to the session, for undo. */
  private gestures: number[] = [];
  private moving = false;
  private readonly live = new Newest<null>(() => this.sendLive());
  private readonly reading = new Newest<null>(() => this.askMetrics());

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

  readonly canUndo = $derived(
    this.mode === 'whatif' ? this.drafts.length > 0 : (this.session.info?.changes.length ?? 0) > 0,
  );

  async start(): Promise<void> {
    await this.try(async () => {
      [this.scenarios, this.parts] = await Promise.all([this.api.scenarios(), this.api.parts()]);
      await this.session.open();
      await this.afterLoad();
      const motor = this.draft.plant;
      if (typeof motor === 'string') await this.resolve('plant', motor);
    });
  }

  /** Runs something that talks to the server; a failure becomes a message. */
  async try(action: () => Promise<void>): Promise<void> {
    try {
      await action();
    } catch (error) {
      messages.error(wordsOf(error));
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
    this.problems = Object.fromEntries(
      Object.entries(this.problems).filter(([path]) => !(path in changes)),
    );
    if (this.mode === 'whatif') this.setDraft(changes, begins);
    else void this.setLive(changes, begins);
  }

  /** Playing shows what plays: what-if changes stay where they are, unapplied. */
  async playOrPause(): Promise<void> {
    const { session } = this;
    if (!(await session.settled())) return;
    if (session.info?.state === 'playing') {
      await this.try(() => session.pause());
    } else {
      this.setMode('live');
      await this.try(() => session.play());
    }
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
      messages.error(`STOP was not taken. ${wordsOf(error)}`);
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

  /** Takes a whole trajectory as a what-if change, in place of changes of the present one. */
  tryTrajectory(trajectory: Trajectory): void {
    this.forget(Object.keys(this.draft).filter(ofTrajectory));
    this.setMode('whatif');
    this.set({ trajectory: trajectory as Value });
  }

  /** Gives a whole trajectory to the session, which begins anew at 0 s. */
  async giveTrajectory(trajectory: Trajectory): Promise<void> {
    await this.try(async () => {
      await this.give({ trajectory: trajectory as Value });
      this.forget(Object.keys(this.draft).filter(ofTrajectory));
      this.setMode('live');
    });
  }

  async undo(): Promise<void> {
    if (this.mode === 'whatif') {
      this.keepDraft(this.drafts.at(-1) ?? {});
      this.drafts = this.drafts.slice(0, -1);
      return;
    }
    await this.try(async () => {
      let steps = 0;
      // A gesture whose values were overtaken before they were sent has changed nothing.
      while (steps === 0 && this.gestures.length > 0) steps = this.gestures.pop() ?? 0;
      steps = Math.max(1, steps);
      for (let i = 0; i < steps; i++) await this.session.undo();
    });
  }

  discard(): void {
    this.drafts = [...this.drafts, this.draft];
    this.keepDraft({});
  }

  /** Gives what-if changes to the session: at its next tick, or from 0 s where they need that. */
  async apply(): Promise<void> {
    await this.try(async () => {
      await this.give(this.draft);
      this.drafts = [];
      this.keepDraft({});
    });
  }

  /** Opens a scenario in place of the present one, with changes if there are any. */
  async loadScenario(scenario: string | Scenario, set: Changes = {}): Promise<void> {
    await this.try(async () => {
      await this.session.create({ scenario, set });
      this.drafts = [];
      this.keepDraft({});
      await this.afterLoad();
    });
  }

  async upload(file: File): Promise<void> {
    await this.try(async () => this.loadScenario(await this.api.parse(await file.text())));
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

  private async setLive(changes: Changes, begins: boolean): Promise<void> {
    if (begins) this.gestures.push(0);
    this.unsent = { ...this.unsent, ...changes };
    this.live.push(null);
  }

  private async sendLive(): Promise<void> {
    const set = this.unsent;
    if (Object.keys(set).length === 0) return;
    try {
      await this.give(set);
      this.gestures.push((this.gestures.pop() ?? 0) + 1);
    } catch (error) {
      if (error instanceof ApiError) this.refuse(error.problem.errors, error.message);
      else throw error;
    } finally {
      const kept = Object.entries(this.unsent).filter(([path, value]) => set[path] !== value);
      this.unsent = Object.fromEntries(kept);
    }
    await new Promise((resolve) => setTimeout(resolve, LIVE_SPACING));
  }

  private async give(set: Changes): Promise<void> {
    await this.session.settled();
    const current = this.session.info;
    if (!current) return;
    if (Object.keys(set).some(needsRestart)) {
      const base = this.session.base ?? current.base;
      await this.session.create({ scenario: current.scenario, set }, base);
      this.gestures = [];
      messages.info('Trajectory and seed hold from the start: the session went back to 0 s.');
    } else {
      await this.session.patch(set);
    }
  }

  private forget(paths: readonly string[]): void {
    const kept = Object.entries(this.draft).filter(([path]) => !paths.includes(path));
    this.keepDraft(Object.fromEntries(kept));
  }

  private keepDraft(draft: Changes): void {
    this.draft = draft;
    save('draft', draft);
  }

  /** Looks up what a shipped part consists of, so that the controls can show it. */
  private async resolve(path: 'plant', name: string): Promise<void> {
    const key = `${path}=${name}`;
    if (key in this.resolved) return;
    const scenario = await this.api.parse(`base = "circle"\n${path} = "${name}"\n`);
    this.resolved = { ...this.resolved, [key]: scenario[path] };
  }

  private async afterLoad(): Promise<void> {
    this.gestures = [];
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

export const lab = new Lab();
