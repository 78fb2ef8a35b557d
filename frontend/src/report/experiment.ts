/** A run of a report, simulated by the page with other gains. */

import { runOf, sameRun } from '../app/whatif/run-request';
import { Engine } from '../kernel/engine';
import { type Result, resultOf } from '../kernel/result';
import type { Column, Curve, Inputs, Run, RunResult } from '../kernel/tasks';
import { type ReportLanes, withFields } from './copied-fields';

/** Most memory of a run, bytes. */
const MOST = 64e6;

export class Experiment {
  readonly variants: readonly string[];
  private readonly engine: Engine;
  private latest: readonly { run: Run; result: RunResult }[] = [];

  constructor(
    module: WebAssembly.Module,
    private readonly lanes: ReportLanes,
    inputs: Inputs,
  ) {
    this.engine = new Engine(module, MOST);
    if (lanes.module !== this.engine.about.module) {
      throw new Error('the kernel is of another version than the run');
    }
    this.engine.take(inputs);
    this.variants = Object.keys(lanes.windows[0]?.variants ?? {});
  }

  /** Runs with other values of some fields. */
  run(values: ReadonlyMap<string, number>): Result {
    const numbers = withFields(this.lanes, values);
    if (!numbers) throw new Error('a gain is out of its range');
    const lanes = { ...this.lanes, lanes: numbers };
    const { first, stop } = lanes;
    this.latest = this.variants.map((variant, i) => {
      const whole = runOf(lanes, variant, i, [], { from: first, to: stop, size: 1 });
      const run = { ...whole, linear: false }; // a report shows no margins
      const before = this.latest[i];
      // A variant that no change concerns keeps its samples.
      return before && sameRun(before.run, run) ? before : { run, result: this.engine.run(run) };
    });
    return resultOf(
      lanes,
      this.latest.map(({ result }) => result),
    );
  }

  /** Reads a column of the latest run over ticks [from, to) in bins of so many samples. */
  curve(variant: string, column: Column, from: number, to: number, size: number): Curve {
    const [curve] = this.engine.curves(variant, [column], { from, to, size });
    return curve as Curve;
  }

  /** Ticks [first, stop) are simulated. */
  get first(): number {
    return this.lanes.first;
  }
  get stop(): number {
    return this.lanes.stop;
  }
}
