/** The tour: which step is shown, and what of the page it has changed. */

import { equal } from '../../app/api/scenario-paths';
import type { Changes } from '../../app/api/types';
import { screen } from '../../app/screen.svelte';
import { takenBack, type Staged } from './rules';
import { load, save } from '../../app/storage';
import { app } from '../../app/store.svelte';
import type * as steps from './steps';

const KEY = 'tour';

class Tour {
  /** The step, from 0; null while the tour is not on. */
  at = $state<number | null>(null);
  /** Loaded with the first step. */
  steps = $state.raw<typeof steps.STEPS>([]);
  /** Offered on the first visit, until it is answered or the page is left. */
  offered = $state(false);
  private staged: Staged | null = null;

  /** Whether this browser is here for the first time. */
  greet(): void {
    this.offered = load<string>(KEY, '') === '';
    save(KEY, 'offered');
  }

  start = () =>
    app.try(async () => {
      this.offered = false;
      this.steps = (await import('./steps')).STEPS;
      this.go(0);
    });

  /** Shows a step: those before Trajectories are on the Lab. */
  go(to: number): void {
    this.takeBack();
    closeSheets();
    this.at = Math.min(Math.max(0, to), this.steps.length - 1);
    if (this.steps[this.at]?.screen === 'lab') screen.go('lab');
  }

  leave(): void {
    this.takeBack();
    closeSheets();
    this.at = null;
  }

  /** Stages changes for as long as the step is shown. */
  readonly stage = (changes: Changes): void => {
    this.staged ??= { changes, before: app.draft, mode: app.mode };
    app.setMode('whatif');
    app.set(changes);
  };

  private takeBack(): void {
    if (!this.staged) return;
    const draft = takenBack(app.draft, this.staged);
    if (!equal(draft, app.draft)) app.whatIfChanges.replace(draft);
    app.setMode(this.staged.mode);
    this.staged = null;
  }
}

function closeSheets(): void {
  document.querySelectorAll<HTMLDialogElement>('dialog.sheet[open]').forEach((sheet) => {
    sheet.close();
  });
}

export const tour = new Tour();
