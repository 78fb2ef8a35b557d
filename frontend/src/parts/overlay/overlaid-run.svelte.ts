/** One run that is drawn behind the curves of the Lab. */

import type { Range, StillSource } from '../../plot/source';
import type { Metrics, RunDetail } from '../../app/api/types';
import { errorText } from '../../app/error-text';
import { toRead } from '../../app/runs/run-range';
import { RunSource } from '../runs/run-source.svelte';
import { getRun } from '../runs/runs-api';
import type { Placed } from './overlay-address';

/** After a failure it is asked again this much later, ms. */
const AGAIN = 5000;

export class OverlaidRun implements Placed {
  readonly id: string;
  offset = $state(0);
  shown = $state(true);
  run = $state.raw<RunDetail | null>(null);
  private curves = $state.raw<RunSource | null>(null);
  private refused = $state('');
  private readonly whole = $derived(this.curves?.whole?.shifted(this.offset) ?? null);
  private askedAt = Number.NEGATIVE_INFINITY;
  private placed: { source: StillSource; offset: number; shifted: StillSource } | null = null;

  constructor(
    { id, offset, shown }: Placed,
    /** Tells it from the others: 0 to 3, as long as it is overlaid. */
    readonly slot: number,
  ) {
    this.id = id;
    this.offset = offset;
    this.shown = shown;
    void this.load();
  }

  get name(): string {
    return this.run?.name ?? this.id;
  }

  /** Whether a person wrote it; an id stands as it is too. */
  get named(): boolean {
    return this.run?.named ?? true;
  }

  get problem(): string {
    return this.refused || (this.curves?.problem ?? '');
  }

  /** Whether its curves are still to come. */
  get reading(): boolean {
    return this.problem === '' && !this.whole;
  }

  /** Its metrics; null where it has none. */
  get metrics(): Metrics | null {
    const result = this.run?.result as unknown as Partial<Metrics> | undefined;
    return result?.variants && result.window ? (result as Metrics) : null;
  }

  /** Reads what is missing of these columns over a stretch of time of the Lab. */
  look(columns: readonly string[], { from, to }: Range, moving: boolean): void {
    const { run, curves, offset } = this;
    if (this.problem !== '' && performance.now() - this.askedAt < AGAIN) return;
    if (run && !curves) {
      this.askedAt = performance.now();
      void this.load();
    }
    if (!run || !curves || curves.busy) return;
    const visible = { from: from - offset, to: to - offset };
    const other = curves.choose(columns);
    const reading = toRead(visible, other ? [] : [curves.whole, curves.part], run, { moving });
    if (!reading && !other && curves.whole) return;
    this.askedAt = performance.now();
    // The whole comes first; it may be fine enough.
    curves.read(curves.whole && !other ? reading : null);
  }

  /** Its curves over a stretch of time of the Lab. */
  over(range: Range): StillSource | null {
    const { offset, curves } = this;
    const source = curves?.over({ from: range.from - offset, to: range.to - offset });
    if (!source) return null;
    // The same object while it shows the same, so that it is not drawn again.
    if (source !== this.placed?.source || offset !== this.placed.offset) {
      this.placed = { source, offset, shifted: source.shifted(offset) };
    }
    return this.placed.shifted;
  }

  has(column: string): boolean {
    return this.whole?.has(column) ?? false;
  }

  private async load(): Promise<void> {
    try {
      const run = await getRun(this.id);
      if (run.state === 'recording') {
        this.refused = 'It is being recorded until its session is reset.';
        this.run = run;
        this.askedAt = performance.now();
        return;
      }
      this.refused = '';
      this.curves = new RunSource(run);
      this.run = run;
    } catch (error) {
      this.refused = errorText(error);
    }
  }
}
