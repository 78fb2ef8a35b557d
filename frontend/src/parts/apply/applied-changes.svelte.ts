/** Changes applied to the Lab by a study, with undo. */

import { equal } from '../../app/api/scenario-paths';
import type { Changes } from '../../app/api/types';
import { app, type Mode } from '../../app/store.svelte';
import { present } from './comparison.svelte';

export class AppliedChanges {
  /** The changes applied last, and the Lab's values before. */
  private last = $state.raw<{ changes: Changes; before: Changes; mode: Mode } | null>(null);

  /** Whether the Lab still has the applied changes. */
  readonly applied = $derived.by(() => {
    const { last } = this;
    if (!last || !app.scenario || app.mode !== last.mode) return false;
    return equal(present(app.scenario, last.changes), last.changes);
  });

  /** How they were applied, to go into a sentence. */
  readonly how = $derived(this.last?.mode === 'live' ? 'in the motor' : 'staged');

  apply(changes: Changes, mode: Mode): void {
    if (!app.scenario) return;
    this.last = { changes, before: present(app.scenario, changes), mode };
    app.setMode(mode);
    app.set(changes);
  }

  undo(): void {
    if (!this.last) return;
    app.setMode(this.last.mode);
    app.set(this.last.before);
    this.last = null;
  }
}
