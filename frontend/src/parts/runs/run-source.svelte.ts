/** Curves of one run from the server: the whole of it, what is looked at, and what is near that. */

import { isMath, StillSource, type Range } from '../../plot/source';
import { readCurves } from '../../app/api/curves-answer';
import type { RunDetail } from '../../app/api/types';
import { errorText } from '../../app/error-text';
import { LatestWins } from '../../app/latest-wins';
import { app } from '../../app/store.svelte';
import {
  BINS,
  EVERY,
  nearby,
  samplesOf,
  stepFor,
  toRead,
  wholeOf,
  type Reading,
} from '../../app/runs/run-range';
import { SeenCurves } from '../../app/runs/seen-curves';
import { runWindow } from './runs-api';

/** What is near is read once nothing has been asked for so long, ms. */
const REST = 50;

export class RunSource {
  whole = $state.raw<StillSource | null>(null);
  part = $state.raw<StillSource | null>(null);
  problem = $state('');
  private columns: readonly string[] = [];
  /** The columns that `whole` and `part` have. */
  private present: readonly string[] = [];
  private readonly seen = new SeenCurves();
  /** Counts what was read, for those who look at `seen`. */
  private readings = $state(0);
  private readonly questions = new LatestWins<Reading | null>((part) => this.answer(part));
  private rest: ReturnType<typeof setTimeout> | undefined;
  private visible: Range | null = null;
  private ahead = false;

  /**
   * @param coarse whether the whole run is read first, for what lies beyond the part
   * @param finer how many times finer than a scope has pixels: a path goes round within few of them
   */
  constructor(
    readonly run: RunDetail,
    private readonly coarse = true,
    private readonly finer = 1,
  ) {}

  get busy(): boolean {
    return this.questions.busy;
  }

  /** Chooses columns, those that the run has; whether others than before. */
  choose(names: readonly string[]): boolean {
    const columns = this.there(names);
    if (columns.join() === this.columns.join()) return false;
    this.columns = columns;
    return true;
  }

  /** Reads a part; without one, the whole. */
  read(part: Reading | null): void {
    this.questions.push(part);
  }

  /** Reads what is missing of a stretch of time that is looked at; what is near it follows. */
  look(visible: Range): void {
    this.visible = visible;
    const others = this.columns !== this.present;
    const best = this.seen.best(this.present, visible, stepFor(visible, this.run, this.finer));
    const there = others ? (this.coarse ? wholeOf(this.run) : null) : best;
    const reading = toRead(visible, [there], this.run, { finer: this.finer });
    if (others || reading) this.read(reading);
    else this.readAhead();
  }

  /** What is drawn of a stretch of time: as fine as there are pixels, until that has come the finest there is. */
  over(range: Range): StillSource | null {
    void this.readings;
    const best = this.seen.best(this.present, range, stepFor(range, this.run, this.finer));
    return best ?? this.whole;
  }

  /** Every sample of a stretch of those columns that the run has. */
  async samples(names: readonly string[], range: Range): Promise<StillSource | null> {
    const columns = this.there(names);
    if (columns.length === 0 || this.run.ticks === 0) return null;
    return this.curves(columns, { range, points: EVERY });
  }

  /** Of these columns, those that the run has, and the math channels that can be computed of it. */
  private there(names: readonly string[]): string[] {
    const whose = { run: this.run.id };
    const math = names.filter(isMath);
    if (math.length > 0) app.expressions.want(whose, math);
    const computed = math.filter((column) => app.expressions.of(whose, column)?.problem === null);
    const recorded = this.run.columns.flatMap(({ name = '' }) =>
      names.includes(name) ? [name] : [],
    );
    return [...recorded, ...computed];
  }

  private async answer(part: Reading | null): Promise<void> {
    const { columns } = this;
    if (columns.length === 0 || this.run.ticks === 0) return;
    try {
      if (columns !== this.present && this.coarse) {
        const range = { from: 0, to: this.run.duration };
        this.whole = await this.curves(columns, { range, points: BINS });
        this.seen.put(columns, this.whole);
        this.part = null;
      }
      this.present = columns;
      this.readings += 1;
      if (part) {
        this.part = await this.curves(columns, part);
        this.seen.put(columns, this.part);
        this.readings += 1;
      }
      this.problem = '';
      this.readAhead();
    } catch (error) {
      this.problem = errorText(error);
    }
  }

  /** Reads what is near what is looked at, so that zooms and moves find it there. */
  private readAhead(): void {
    clearTimeout(this.rest);
    this.rest = setTimeout(() => void this.readNear(), REST);
  }

  private async readNear(): Promise<void> {
    const { visible, columns, run } = this;
    if (!visible || this.ahead || this.busy || columns !== this.present) return;
    const next = nearby(visible, run, columns.length).find(
      ({ range, step }) => !this.seen.has(columns, range, step),
    );
    if (!next) return;
    this.ahead = true;
    try {
      this.seen.put(columns, await this.curves(columns, next));
      this.ahead = false;
      this.readAhead();
    } catch {
      // It was only read ahead; it is read when it is looked at.
      this.ahead = false;
    }
  }

  private async curves(columns: readonly string[], { range, points }: Reading) {
    const query = { ...samplesOf(range, this.run), columns: columns.join(), points };
    const { time, columns: curves } = readCurves(await runWindow(this.run.id, query));
    return new StillSource(time.start, time.step, time.count, curves);
  }
}
