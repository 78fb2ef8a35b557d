/** A retiming that is proposed: what it would cost is known before it is taken. */

import { ApiError } from '../../app/api/client';
import { equal } from '../../app/api/scenario-paths';
import { errorText } from '../../app/error-text';
import { LatestWins } from '../../app/latest-wins';
import { asTable, type DrawnPath } from './drawn-path';
import { editor } from './editor.svelte';
import type { Checked } from './feasibility';
import { timingOf, type Timing } from './retiming-cost';

class Retiming {
  private timing = $state.raw<Timing | null>(null);
  found = $state.raw<Checked | null>(null);
  refused = $state('');
  private foundOf = $state.raw<DrawnPath | null>(null);
  private readonly checks = new LatestWins<DrawnPath>((path) => this.check(path));

  /** The path as it would be; null while nothing is proposed. */
  readonly path = $derived(
    this.timing && editor.path && !equal(this.timing, timingOf(editor.path))
      ? { ...editor.path, ...this.timing }
      : null,
  );

  /** Whether what was found is of what is proposed. */
  readonly fresh = $derived(this.path !== null && equal(this.path, this.foundOf));

  propose(path: DrawnPath): void {
    this.timing = timingOf(path);
  }

  /** Asks what the proposal demands of the motor. */
  ask(): void {
    if (this.path) this.checks.push(this.path);
  }

  apply(): void {
    if (this.path) editor.edit(this.path);
    this.discard();
  }

  discard(): void {
    [this.timing, this.found, this.foundOf, this.refused] = [null, null, null, ''];
  }

  private async check(path: DrawnPath): Promise<void> {
    try {
      const found = await editor.examine(asTable(path));
      [this.found, this.foundOf, this.refused] = [found, path, ''];
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      [this.found, this.foundOf, this.refused] = [null, path, errorText(error)];
    }
  }
}

export const retiming = new Retiming();
