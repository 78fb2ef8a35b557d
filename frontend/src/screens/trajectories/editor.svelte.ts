/** The path under the hand: its history, what the server says of it, and what A and B make of it. */

import { ApiError } from '../../app/api/client';
import { equal } from '../../app/api/scenario-paths';
import type { Changes, ProblemField, Trajectory } from '../../app/api/types';
import { demo } from '../../app/demo/demo-mode';
import { fieldErrorsText, errorText } from '../../app/error-text';
import { LatestWins } from '../../app/latest-wins';
import { GIVEN_PATH, type GivenPath } from '../../app/session/kept-sessions';
import { load, nullOr, save } from '../../app/storage';
import { app } from '../../app/store.svelte';
import { WhatIf } from '../../app/whatif/whatif.svelte';
import {
  asPath,
  asTable,
  fewest,
  keptTable,
  repeated,
  type DrawnPath,
  type Table,
} from './drawn-path';
import { readChecked, type Checked } from './feasibility';
import { polygon } from './geometry';
import { chosenOf } from './selection';
import { shape, type Shape } from './shapes';
import { History } from './undo-history';

export type Tool = 'edit' | 'select' | 'add' | 'draw' | 'move';

/** Longest motion that is simulated while a hand moves, and longest that is at all, s. */
const LONGEST = { moving: 10, resting: 120 };

/** Bins of the profiles: about one for each pixel of their width. */
const POINTS = 400;

export class Editor {
  table = $state.raw<Table>(keptTable(load('path', null)) ?? asTable(shape('rhombus')));
  /** Selected points, in the order in which they were chosen. */
  chosen = $state.raw(chosenOf());
  tool = $state<Tool>('edit');
  /** Grid that points snap to, m. */
  step = $state(load('path-step', 1e-3));
  name = $state(load('path-name', ''));
  /** What was opened or saved last, and as what. */
  private saved = $state.raw<GivenPath | null>(load('path-saved', null, nullOr(GIVEN_PATH)));
  /** What the server found about `checkedOf`. */
  checked = $state.raw<Checked | null>(null);
  private checkedOf = $state.raw<Table | null>(null);
  /** Why the server refuses the table as it stands, or what it lacks. */
  refused = $state('');
  lastFeasible = $state.raw<Table | null>(null);
  canUndo = $state(false);
  canRedo = $state(false);
  /** Bin of the profiles that a pointer is over. */
  cursor = $state<number | null>(null);
  readonly whatif = new WhatIf(
    app.api,
    (fields, detail) => this.complain(fields, detail),
    app.kernel,
    demo !== null,
  );
  problem = $state('');
  private moving = false;
  private readonly history = new History<Table>();
  private readonly checks = new LatestWins<Table>((table) => this.check(table));

  readonly path = $derived(asPath(this.table));

  /** The point that was chosen last, or null. */
  get selected(): number | null {
    return [...this.chosen].at(-1) ?? null;
  }

  /** Chooses one point and no other. */
  set selected(index: number | null) {
    this.chosen = chosenOf(index === null ? [] : [index]);
  }

  /** The table with its saved name, as the Lab takes it. */
  readonly namedPath = $derived.by((): GivenPath => {
    const name = equal(this.table, this.saved?.table) ? (this.saved?.name ?? '') : '';
    return { name, table: this.table };
  });

  /** Whether what the server found is of the path as it stands. */
  readonly fresh = $derived(this.checkedOf === this.table);

  /** The curve of the path: a smooth one as the server last answered. */
  readonly outline = $derived.by(() => {
    if (this.path?.geometry !== 'spline') return this.path && polygon(this.path);
    return this.refused === '' ? (this.checked?.outline ?? null) : null;
  });

  /** The figure as a path whose points can be dragged. */
  readonly convertible = $derived(this.fresh ? (this.checked?.drawn ?? null) : null);

  readonly feasible = $derived(
    this.fresh && this.refused === '' && this.checked?.feasible === true,
  );

  /** Replaces the trajectory; changes of one named gesture in quick succession are undone as one. */
  set(table: Table, gesture = ''): void {
    if (equal(table, this.table)) return;
    this.history.keep(this.table, gesture, performance.now());
    this.moving = gesture.startsWith('drag');
    this.adopt(table);
  }

  edit(path: DrawnPath, gesture = ''): void {
    this.set(asTable(path), gesture);
  }

  /** Ends a gesture. */
  rest(): void {
    this.history.pause();
    if (!this.moving) return;
    this.moving = false;
    save('path', this.table);
    if (this.feasible) this.simulate(this.table);
  }

  undo(): void {
    this.moving = false;
    this.adopt(this.history.undo(this.table));
  }

  redo(): void {
    this.moving = false;
    this.adopt(this.history.redo(this.table));
  }

  start(which: Shape): void {
    this.edit(shape(which));
    this.rename('');
    this.selected = null;
    this.tool = which === 'empty' ? 'add' : 'edit';
  }

  /** Makes an editable path of a figure. */
  convert(): void {
    if (this.convertible) this.set(this.convertible);
  }

  setStep(step: number): void {
    this.step = step;
    save('path-step', step);
  }

  /** Asks the server about the path as it stands. */
  ask(): void {
    this.checks.push(this.table);
  }

  backToFeasible(): void {
    if (this.lastFeasible) this.set(this.lastFeasible);
  }

  /** Returns the motion stretched until the motor can follow it; null where that fails. */
  async slower(): Promise<{ trajectory: Table; stretch: number } | null> {
    const table = this.table;
    let slowed = null;
    await app.try(async () => {
      slowed = await app.api.slow(this.request(table));
    });
    return table === this.table ? slowed : null;
  }

  async open(name: string): Promise<void> {
    await app.try(async () => {
      const { trajectory } = await app.api.trajectory(name);
      this.set(trajectory);
      this.selected = null;
      this.named(name, trajectory);
    });
  }

  /** Takes the name that a table has on the server. */
  named(name: string, table: Table): void {
    this.name = name;
    this.saved = { name, table };
    save('path-name', name);
    save('path-saved', this.saved);
  }

  /** Takes another name for what is on the screen, which is not saved as that yet. */
  rename(name: string): void {
    this.name = name;
    this.saved = null;
    save('path-name', name);
    save('path-saved', null);
  }

  /** The path that was opened or saved last, with its name; null where it is new. */
  get lastSaved(): GivenPath | null {
    return this.saved;
  }

  private adopt(table: Table): void {
    this.table = table;
    this.canUndo = this.history.canUndo;
    this.canRedo = this.history.canRedo;
    const count = this.path?.points.length ?? 0;
    if ([...this.chosen].some((index) => index >= count)) {
      this.chosen = chosenOf([...this.chosen].filter((index) => index < count));
    }
    // Storage is slow: what a hand moves is kept when it rests.
    if (!this.moving) save('path', table);
  }

  /** Asks what another trajectory demands of the motor. */
  async examine(trajectory: Table): Promise<Checked> {
    return readChecked(await app.api.check(this.request(trajectory)));
  }

  /** A trajectory, and the motor and gains that it is for: the session with its what-if changes. */
  planned(trajectory: Trajectory): {
    scenario: NonNullable<typeof app.session.info>['scenario'];
    set: Changes;
    trajectory: Trajectory;
  } {
    const scenario = app.session.info?.scenario;
    if (!scenario) throw new Error('There is no session yet.');
    const others = Object.entries(app.draft).filter(([path]) => !path.startsWith('trajectory'));
    return { scenario, set: Object.fromEntries(others), trajectory };
  }

  private request(trajectory: Trajectory) {
    return { ...this.planned(trajectory), points: POINTS };
  }

  private async check(table: Table): Promise<void> {
    const lacking = lacks(asPath(table));
    if (lacking !== '') {
      this.show(table, null, lacking);
      return;
    }
    try {
      const checked = await this.examine(table);
      this.show(table, checked, '');
      if (!checked.feasible) return;
      this.lastFeasible = table;
      if (!this.moving || checked.duration <= LONGEST.moving) this.simulate(table);
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.show(table, this.checked, errorText(error));
    }
  }

  /** Takes what was found of a table. */
  private show(table: Table, checked: Checked | null, refused: string): void {
    this.checked = checked;
    this.checkedOf = table;
    this.refused = refused;
  }

  /** Asks what A and B make of the path. */
  private simulate(table: Table): void {
    if (!this.checked || this.checked.duration > LONGEST.resting) return;
    const { scenario, set, trajectory } = this.planned(table);
    const changes = { ...set, trajectory: trajectory as Changes[string] };
    this.whatif.ask({ scenario, set: changes, columns: [] });
  }

  private complain(fields: readonly ProblemField[], detail: string): void {
    this.problem = fields.length > 0 ? fieldErrorsText(fields) : detail;
  }
}

/** Returns what a drawn path lacks before anything can be said of it. */
function lacks(path: DrawnPath | null): string {
  if (!path) return '';
  const least = fewest(path);
  if (path.points.length < least) {
    return `Set ${least} points or more: choose Add and click on the plane.`;
  }
  const twice = repeated(path);
  const next = twice === null ? 0 : ((twice + 1) % path.points.length) + 1;
  return twice === null ? '' : `Points ${twice + 1} and ${next} are at the same place.`;
}

export const editor = new Editor();
