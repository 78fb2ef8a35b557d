/** What Undo takes back: a gesture of what-if, one of the live session, or the session itself. */

import { changedPaths } from './api/scenario-paths';
import type { Changes } from './api/types';
import type { Action } from './messages.svelte';
import { is } from './session/gestures';
import type { LiveChanges } from './session/live-changes.svelte';
import { listed, type ReplacedSession } from './session/replaced-session';
import type { Store } from './store.svelte';

/** Sessions that Undo can go back to. */
const BACK_MAX = 20;

export class Undo {
  /** Sessions that others took the place of, the oldest first: Undo goes back to the last one. */
  private replaced = $state.raw<readonly ReplacedSession[]>([]);
  /** The what-if changes that the session was given last: undone, they are what-if changes again. */
  private applied = $state.raw<Pick<ReplacedSession, 'draft' | 'drafts'> | null>(null);

  constructor(
    private readonly store: Store,
    private readonly live: LiveChanges,
  ) {}

  /** The session's last change; the server's account of it may come later. */
  private readonly lastChange = $derived.by(() => this.store.session.info?.changes.at(-1));

  /** Whether the session's last change gave it the what-if changes. */
  private readonly undoesApply = $derived(
    this.applied !== null &&
      this.lastChange !== undefined &&
      is(this.lastChange, this.applied.draft),
  );

  /** Whether what-if has a gesture to take back, before all that was done to the session. */
  private readonly undoesDraft = $derived.by(
    () => this.store.mode === 'whatif' && this.store.whatIfChanges.history.length > 0,
  );

  /** Whether Undo goes back to the session before this one, in which nothing was changed yet. */
  readonly goesBack = $derived.by(
    () =>
      this.replaced.length > 0 &&
      !this.undoesDraft &&
      this.store.session.info?.changes.length === 0,
  );

  /** What Undo will do; empty where there is nothing to take back. */
  readonly text = $derived.by((): string => {
    const { mode, draft, whatIfChanges } = this.store;
    if (this.undoesDraft) {
      const paths = changedPaths(whatIfChanges.history.at(-1) ?? {}, draft);
      return `Take back the staged change of ${listed(paths)}`;
    }
    if (this.goesBack) {
      return `Go back to the session before, ${this.replaced.at(-1)?.scenario.name}, at 0 s`;
    }
    if (mode === 'whatif' && !this.undoesApply) return '';
    if (!this.lastChange) return '';
    const what = listed(Object.keys(this.lastChange.set));
    return this.undoesApply
      ? `Take back what was sent to the motor: ${what}`
      : `Take back the change of ${what}`;
  });

  readonly possible = $derived(this.text !== '');

  async run(): Promise<void> {
    const { store } = this;
    store.rest();
    if (this.goesBack) {
      await store.try(async () => {
        // A change may have been made that the server has not reported yet.
        await this.live.sent();
        await store.session.refresh();
      });
      if (this.goesBack) {
        await this.goBack();
        return;
      }
    }
    if (this.undoesDraft) store.whatIfChanges.undo();
    else if (store.mode === 'live' || this.undoesApply) {
      await store.try(() => this.live.undo(() => this.takeBack()));
    }
  }

  /** Forgets what was done to a session, as there is another one. */
  clear(): void {
    this.live.clear();
    this.applied = null;
  }

  noteApplied(draft: Changes, drafts: readonly Changes[]): void {
    this.applied = { draft, drafts };
  }

  /** Keeps a session that was replaced; returns what a message offers to go back to it. */
  noteReplaced(before: ReplacedSession): Action {
    this.replaced = [...this.replaced.slice(1 - BACK_MAX), before];
    return { name: 'Undo', run: () => void this.goBack(before) };
  }

  /** Takes the session's last gesture back. */
  private async takeBack(): Promise<void> {
    const { session, whatIfChanges } = this.store;
    const { changes } = await session.refresh();
    const { applied, undoesApply } = this;
    for (let count = this.live.take(changes); count > 0; count--) await session.undo();
    if (!applied || !undoesApply) return;
    this.applied = null;
    whatIfChanges.restore(applied.draft, applied.drafts);
  }

  /** Goes back to what a session took the place of, at 0 s, unless that has been done already. */
  private async goBack(before = this.replaced.at(-1)): Promise<void> {
    const { store } = this;
    if (!before || !this.replaced.includes(before)) return;
    await store.try(async () => {
      await store.session.create({ scenario: before.scenario }, before);
      this.replaced = this.replaced.slice(0, this.replaced.indexOf(before));
      store.whatIfChanges.history = before.drafts;
      await store.afterLoad();
      store.setMode(before.mode);
    });
  }
}
