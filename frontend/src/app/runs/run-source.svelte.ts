/** Curves of one run from the server: the whole of it, and the part that is looked at. */

import { StillSource, type Range } from '../../plot/source';
import { readCurves } from '../api/curves-answer';
import type { RunDetail } from '../api/types';
import { errorText } from '../error-text';
import { LatestWins } from '../latest-wins';
import { BINS, covers, EVERY, samplesOf, type Reading } from './run-range';
import { runWindow } from './runs-api';

export class RunSource {
  whole = $state.raw<StillSource | null>(null);
  part = $state.raw<StillSource | null>(null);
  problem = $state('');
  private columns: readonly string[] = [];
  /** The columns that `whole` and `part` have. */
  private present: readonly string[] = [];
  private readonly questions = new LatestWins<Reading | null>((part) => this.answer(part));

  /** @param coarse whether the whole run is read too, for what lies beyond the part */
  constructor(
    readonly run: RunDetail,
    private readonly coarse = true,
  ) {}

  get busy(): boolean {
    return this.questions.busy;
  }

  /** Chooses columns, those that the run has; whether others than before. */
  choose(wanted: readonly string[]): boolean {
    const columns = this.run.columns.flatMap(({ name = '' }) =>
      wanted.includes(name) ? [name] : [],
    );
    if (columns.join() === this.columns.join()) return false;
    this.columns = columns;
    return true;
  }

  /** Reads a part; without one, the whole. */
  read(part: Reading | null): void {
    this.questions.push(part);
  }

  /** What is drawn of a stretch of time: the part once it has come, until then the whole, which is coarser. */
  over(range: Range): StillSource | null {
    return this.part && covers(this.part, range) ? this.part : this.whole;
  }

  /** Every sample of a stretch of those columns that the run has. */
  async samples(wanted: readonly string[], range: Range): Promise<StillSource | null> {
    const columns = wanted.filter((column) => this.run.columns.some(({ name }) => name === column));
    if (columns.length === 0 || this.run.ticks === 0) return null;
    return this.curves(columns, { range, points: EVERY });
  }

  private async answer(part: Reading | null): Promise<void> {
    const { columns } = this;
    if (columns.length === 0 || this.run.ticks === 0) return;
    try {
      if (columns !== this.present && this.coarse) {
        const range = { from: 0, to: this.run.duration };
        this.whole = await this.curves(columns, { range, points: BINS });
        this.part = null;
      }
      this.present = columns;
      if (part) this.part = await this.curves(columns, part);
      this.problem = '';
    } catch (error) {
      this.problem = errorText(error);
    }
  }

  private async curves(columns: readonly string[], { range, points }: Reading) {
    const query = { ...samplesOf(range, this.run), columns: columns.join(), points };
    const { time, columns: curves } = readCurves(await runWindow(this.run.id, query));
    return new StillSource(time.start, time.step, time.count, curves);
  }
}
