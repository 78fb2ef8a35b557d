/** A retiming that is proposed: what it would cost is known before it is taken. */

import { ApiError } from '../../app/api/client';
import { equal } from '../../app/api/scenario-paths';
import { errorText } from '../../app/error-text';
import { LatestWins } from '../../app/latest-wins';
import { asPath, asTable, type DrawnPath, type Table } from './drawn-path';
import { editor } from './editor.svelte';
import type { Checked } from './feasibility';
import { timingOf, type Timing } from './retiming-cost';

class Retiming {
  private timing = $state.raw<Timing | null>(null);
  /** A slower motion that is no drawn path, and what it is proposed for. */
  private slower = $state.raw<{ of: Table; table: Table } | null>(null);
  /** By how much every move is stretched to be feasible; 0 for any other proposal. */
  private stretched = $state(0);
  checked = $state.raw<Checked | null>(null);
  refused = $state('');
  private checkedOf = $state.raw<Table | null>(null);
  private readonly checks = new LatestWins<Table>((table) => this.check(table));

  /** The path as it would be; null while nothing is proposed. */
  readonly path = $derived(
    this.timing && editor.path && !equal(this.timing, timingOf(editor.path))
      ? { ...editor.path, ...this.timing }
      : null,
  );

  /** The motion as it would be; null while nothing is proposed. */
  readonly table = $derived.by((): Table | null => {
    if (this.path) return asTable(this.path);
    return this.slower?.of === editor.table ? this.slower.table : null;
  });

  /** Whether what was found is of what is proposed. */
  readonly fresh = $derived(this.table !== null && equal(this.table, this.checkedOf));

  /** By how much what is proposed is stretched to be feasible; 0 for any other proposal. */
  get stretch(): number {
    return this.table ? this.stretched : 0;
  }

  propose(path: DrawnPath): void {
    this.discard();
    this.timing = timingOf(path);
  }

  /** Proposes a motion that the server has stretched until the motor can follow it. */
  proposeSlower(table: Table, stretch: number): void {
    this.discard();
    const path = asPath(table);
    if (path) this.timing = timingOf(path);
    else this.slower = { of: editor.table, table };
    this.stretched = stretch;
  }

  /** Asks what the proposal demands of the motor. */
  ask(): void {
    if (this.table) this.checks.push(this.table);
  }

  apply(): void {
    if (this.table) editor.set(this.table);
    this.discard();
  }

  discard(): void {
    [this.timing, this.slower, this.stretched] = [null, null, 0];
    [this.checked, this.checkedOf, this.refused] = [null, null, ''];
  }

  private async check(table: Table): Promise<void> {
    try {
      const retimed = await editor.examine(table);
      [this.checked, this.checkedOf, this.refused] = [retimed, table, ''];
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      [this.checked, this.checkedOf, this.refused] = [null, table, errorText(error)];
    }
  }
}

export const retiming = new Retiming();
