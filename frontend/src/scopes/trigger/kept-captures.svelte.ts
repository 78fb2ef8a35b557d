/** Captures that are runs: the newest of them, and their samples as they are wanted. */

import type { Run } from '../../app/api/types';
import { demo } from '../../app/demo/demo-mode';
import { errorText } from '../../app/error-text';
import { app } from '../../app/store.svelte';
import { RunSource } from '../../parts/runs/run-source.svelte';
import { changeRun, getRun, listRuns } from '../../parts/runs/runs-api';
import { isMath } from '../../plot/math-column';
import type { Capture } from './captures';

/** The search that finds all of them. */
export const CAPTURES = 'tag:capture';
/** Most that are listed. */
export const LISTED_MAX = 50;

export class KeptCaptures {
  /** The newest first. */
  runs = $state.raw<readonly Run[]>([]);
  /** How many there are, also those that are not listed. */
  total = $state(0);
  problem = $state('');
  private readonly sources: Record<string, Promise<RunSource>> = {};
  /** The columns that were last read, by run. */
  private readonly present: Record<string, string> = {};

  async read(): Promise<void> {
    if (demo !== null) return;
    try {
      const page = await listRuns({ q: CAPTURES, sort: '-created', limit: LISTED_MAX });
      this.runs = page.runs;
      this.total = page.total;
      this.problem = '';
    } catch (error) {
      this.problem = errorText(error);
    }
  }

  /** Takes one that has just been kept. */
  add(run: Run): void {
    this.runs = [run, ...this.runs].slice(0, LISTED_MAX);
    this.total += 1;
  }

  /** Pins a capture, which is never evicted then, or unpins it. */
  async pin(id: string, pinned: boolean): Promise<void> {
    await app.try(async () => {
      const run = await changeRun(id, { pinned });
      this.runs = this.runs.map((each) => (each.id === id ? run : each));
    });
  }

  /**
   * Reads every sample of the columns that a run has; null where they have been asked for already, or it
   * cannot be read, which `problem` says.
   */
  async samples(run: Run, columns: readonly string[]): Promise<Capture | null> {
    const { id, period, ticks, duration, capture } = run;
    const whose = { run: id };
    app.expressions.want(whose, columns.filter(isMath));
    const computed = (column: string) => app.expressions.of(whose, column)?.problem === null;
    const there = columns.filter((column) => !isMath(column) || computed(column));
    if (this.present[id] === there.join()) return null;
    this.present[id] = there.join();
    try {
      this.sources[id] ??= getRun(id).then((detail) => new RunSource(detail));
      const source = await this.sources[id];
      const samples = await source.samples(there, { from: 0, to: duration });
      if (!samples) return null;
      const first = capture?.from_tick ?? 0;
      const tick = capture?.trigger_tick ?? first;
      this.problem = '';
      return {
        key: id,
        time: tick * period,
        range: { from: first * period, to: (first + ticks) * period },
        source: samples.shifted(first * period),
        free: false,
        apart: true,
        origin: null,
        ticks: [first, first + ticks],
        tick,
        run: id,
        problem: '',
      };
    } catch (error) {
      Reflect.deleteProperty(this.sources, id);
      Reflect.deleteProperty(this.present, id);
      this.problem = `${run.name} cannot be shown: ${errorText(error)}`;
      return null;
    }
  }
}
