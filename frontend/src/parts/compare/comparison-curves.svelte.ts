/** Curves of one channel of two runs: the whole overlap, or a part that the server is asked for again. */

import { errorText } from '../../app/error-text';
import { LatestWins } from '../../app/latest-wins';
import type { Range } from '../../plot/range';
import { compareWindow } from '../runs/runs-api';
import { bodyOf, type How } from './compare-request';
import { ComparisonWindow } from './comparison-window';

/** Bins; more than a plot has pixels. */
const POINTS = 1000;
/** Fewest instants that are shown. */
const LEAST = 12;

export class ComparisonCurves {
  /** Instants that are looked at; null for all. */
  range = $state.raw<Range | null>(null);
  shown = $state.raw<ComparisonWindow | null>(null);
  whole = $state.raw<ComparisonWindow | null>(null);
  problem = $state('');
  /** Place of the axis that readings tell of; NaN for none. */
  cursor = $state(Number.NaN);
  private readonly questions = new LatestWins<Range | null>((range) => this.read(range));

  constructor(
    private readonly pair: readonly [string, string],
    private readonly how: How,
    private readonly channel: string,
    /** The same before a tolerance was changed: what it shows stays until the answer comes. */
    before: ComparisonCurves | null,
  ) {
    if (before) {
      [this.range, this.shown, this.whole] = [before.range, before.shown, before.whole];
    }
    this.questions.push(null);
    if (this.range) this.questions.push(this.range);
  }

  get total(): number {
    return this.whole?.instants.total ?? 0;
  }

  /** Looks at some instants [from, to); null for all. */
  look(range: Range | null): void {
    const { total } = this;
    if (total === 0) return;
    if (range) {
      const length = Math.max(LEAST, Math.round(range.to - range.from));
      const from = Math.round(Math.min(Math.max(0, range.from), Math.max(0, total - length)));
      this.range = length >= total ? null : { from, to: from + length };
    } else {
      this.range = null;
    }
    this.questions.push(this.range);
  }

  zoomBy(ratio: number): void {
    const { from, to } = this.present;
    const at = this.cursorInstant ?? (from + to) / 2;
    const start = at - (at - from) * ratio;
    this.look({ from: start, to: start + (to - from) * ratio });
  }

  moveBy(share: number): void {
    const { from, to } = this.present;
    const shift = share * (to - from);
    if (this.range) this.look({ from: from + shift, to: to + shift });
  }

  reset(): void {
    this.look(null);
  }

  /** Shows the next place beyond the tolerance, or the one before, with as much around it. */
  excursion(way: 1 | -1): void {
    const { whole } = this;
    if (!whole) return;
    const { start, step } = whole.instants;
    const places = whole.excursions().map(({ from, to }) => ({
      from: start + from * step,
      to: start + to * step,
    }));
    const { from, to } = this.present;
    const now = this.range ? (from + to) / 2 : way > 0 ? -1 : whole.instants.total;
    const middles = places.map((place) => (place.from + place.to) / 2);
    // A place that is in the middle, but for rounding, is the present one.
    const apart = Math.max(2, 0.02 * (to - from));
    const next =
      way > 0
        ? middles.findIndex((middle) => middle > now + (this.range ? apart : 0))
        : middles.filter((middle) => middle < now - (this.range ? apart : 0)).length - 1;
    const place = places[next];
    if (!place) return;
    const length = Math.max(
      3 * (place.to - place.from),
      Math.min(to - from, whole.instants.total / 20),
    );
    const middle = (place.from + place.to) / 2;
    this.look({ from: middle - length / 2, to: middle + length / 2 });
  }

  get present(): Range {
    return this.range ?? { from: 0, to: this.total };
  }

  private get cursorInstant(): number | null {
    const { shown, cursor } = this;
    if (!shown || !Number.isFinite(cursor)) return null;
    return shown.instants.start + shown.bin(cursor) * shown.instants.step;
  }

  private async read(range: Range | null): Promise<void> {
    const [a, b] = this.pair;
    const part = range ? { from: range.from, to: range.to } : {};
    try {
      const body = { a, b, ...bodyOf(this.how), channel: this.channel, points: POINTS, ...part };
      const window = ComparisonWindow.read(await compareWindow(body));
      if (!range) this.whole = window;
      // What was asked for meanwhile comes next.
      if ((range === null) === (this.range === null)) this.shown = window;
      this.problem = '';
    } catch (error) {
      this.problem = errorText(error);
    }
  }
}
