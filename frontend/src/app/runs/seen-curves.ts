/** Curves of stretches of time that were read, the coarsest that are fine enough of them. */

import type { Range, SampleSource, StillSource } from '../../plot/source';

/** The part of a stretch of time that lies within a run; null where none does. */
export function within({ from, to }: Range, { duration }: { duration: number }): Range | null {
  const part = { from: Math.max(0, from), to: Math.min(duration, to) };
  return part.to > part.from ? part : null;
}

export type Grid = Pick<SampleSource, 'start' | 'step' | 'last'>;

/** Whether curves reach over a stretch of time. */
export function covers({ start, step, last }: Grid, { from, to }: Range): boolean {
  return start <= from + step && start + last * step >= to - step;
}

/** Most that the curves of one view take, bytes; those used longest ago go first. */
export const SEEN_MAX = 24e6;

/** Curves so much finer than needed are left for coarser ones. */
const FINEST = 16;

interface Seen {
  columns: ReadonlySet<string>;
  source: StillSource;
  bytes: number;
}

export class SeenCurves {
  bytes = 0;
  /** Used longest ago first. */
  private seen: Seen[] = [];

  private drawn: StillSource | null = null;

  constructor(private readonly most = SEEN_MAX) {}

  put(columns: readonly string[], source: StillSource): void {
    // Least and most of each bin, float32.
    const bytes = 8 * columns.length * source.last;
    // What is drawn stays the last one.
    const place =
      this.seen.at(-1)?.source === this.drawn
        ? Math.max(0, this.seen.length - 1)
        : this.seen.length;
    this.seen.splice(place, 0, { columns: new Set(columns), source, bytes });
    this.bytes += bytes;
    while (this.bytes > this.most && this.seen.length > 1) {
      this.bytes -= this.seen.shift()?.bytes ?? 0;
    }
  }

  /**
   * The curves to draw a stretch of time from: the coarsest that are fine enough, for they are drawn
   * fastest, else the finest that there are of all of it. Those drawn last stay while they will do.
   */
  best(columns: readonly string[], range: Range, step: number): StillSource | null {
    const last = this.seen.at(-1);
    const stays = last?.source === this.drawn && last && fits(last, columns, range);
    if (stays && last.source.step <= step && last.source.step * FINEST >= step) return last.source;
    const curves = this.find(columns, range, step);
    if (!curves) return null;
    this.seen = [...this.seen.filter((each) => each !== curves), curves];
    this.drawn = curves.source;
    return curves.source;
  }

  /** Whether there are curves of a stretch of time with at most such bins. */
  has(columns: readonly string[], range: Range, step: number): boolean {
    return (this.find(columns, range, step)?.source.step ?? Number.POSITIVE_INFINITY) <= step;
  }

  private find(columns: readonly string[], range: Range, step: number): Seen | null {
    let best: Seen | null = null;
    for (const each of this.seen) {
      if (!fits(each, columns, range)) continue;
      const [a, b] = [each.source.step, best?.source.step ?? Number.POSITIVE_INFINITY];
      if (b > step ? a < b : a <= step && a > b) best = each;
    }
    return best;
  }
}

function fits({ columns, source }: Seen, names: readonly string[], range: Range): boolean {
  return covers(source, range) && names.every((name) => columns.has(name));
}
