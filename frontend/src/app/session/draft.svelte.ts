/** What-if changes that the session does not have, and how they were before each gesture. */

import { at, equal, without } from '../api/scenario-paths';
import type { Changes } from '../api/types';
import type { SessionStore } from './session.svelte';

export class Draft {
  /** The changes before each gesture that made them, the oldest first. */
  history = $state.raw<readonly Changes[]>([]);
  /** Whether they are here because what was sent was taken back, and were not touched since. */
  takenBack = $state(false);

  constructor(private readonly session: SessionStore) {}

  get changes(): Changes {
    return this.session.draft;
  }

  /** Takes values of a gesture that goes on, or of a new one. */
  put(changes: Changes, begins: boolean): void {
    this.takenBack = false;
    // Changes inside a replaced part are dropped with it.
    const replaced = Object.keys(changes).map((path) => `${path}.`);
    const kept = Object.entries(this.changes).filter(
      ([path]) => !replaced.some((part) => path.startsWith(part)),
    );
    const draft = { ...Object.fromEntries(kept), ...changes };
    const current = this.session.info?.scenario ?? null;
    for (const [path, value] of Object.entries(draft)) {
      const now = path === 'plant' ? at(current, 'plant.name') : at(current, path);
      if (equal(now, value) && !('plant' in draft && path.startsWith('plant.'))) {
        Reflect.deleteProperty(draft, path);
      }
    }
    if (begins) this.replace(draft);
    else this.session.setDraft(draft);
  }

  /** Takes other changes in place of all, as a gesture of its own. */
  replace(changes: Changes): void {
    this.takenBack = false;
    this.history = [...this.history, this.changes];
    this.session.setDraft(changes);
  }

  undo(): void {
    this.takenBack = false;
    this.session.setDraft(this.history.at(-1) ?? {});
    this.history = this.history.slice(0, -1);
  }

  /** Drops changes from the draft, and not as a gesture. */
  forget(paths: readonly string[]): void {
    this.session.setDraft(without(this.changes, paths));
  }

  /** Begins anew: the session has the changes now. */
  clear(): void {
    this.takenBack = false;
    this.history = [];
    this.session.setDraft({});
  }

  /** Puts back what was cleared, below what has come since. */
  restore(changes: Changes, history: readonly Changes[]): void {
    this.takenBack = Object.keys(this.changes).length === 0;
    this.history = [...history, ...this.history];
    this.session.setDraft({ ...changes, ...this.changes });
  }
}
