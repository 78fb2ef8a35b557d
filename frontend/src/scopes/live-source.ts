/** The samples of the running session as a source of curves. */

import type { Ring } from '../app/stream/ring';
import { cut, type Bins } from '../plot/bins';
import type { SampleSource } from '../plot/source';

export class LiveSource implements SampleSource {
  readonly start = 0;

  constructor(
    private readonly ring: () => Ring,
    private readonly period: () => number,
  ) {}

  get step(): number {
    return this.period();
  }

  get version(): number {
    return this.ring().version;
  }
  get revision(): number {
    return this.ring().revision;
  }
  get first(): number {
    return this.ring().start;
  }
  get last(): number {
    return this.ring().end;
  }
  has(column: string): boolean {
    return this.ring().has(column);
  }
  cut(from: number, to: number, pixels: number): Bins {
    return cut(from / this.step, to / this.step, pixels);
  }
  reduce(column: string, bins: Bins, minimum: Float32Array, maximum: Float32Array): void {
    this.ring().reduce(column, bins.first, bins.size, bins.count, minimum, maximum);
  }
  at(column: string, time: number): number {
    const ring = this.ring();
    const tick = Math.round(time / this.step);
    // The newest sample stands for the present, which is one step later.
    return ring.at(column, tick === ring.end ? tick - 1 : tick);
  }
}
