/** Source of curves; the drawing code depends on this interface only. */

import { cut, type Bins } from './bins';
import type { Range } from './range';

export type { Range };

export interface SampleSource {
  /** Changes whenever there is something new to draw. */
  readonly version: number;
  /**
   * Changes when samples are not what they were, or are forgotten before their time; not when new
   * ones follow the last. Only where samples come one after the other.
   */
  readonly revision?: number;
  /** Time of sample 0 and time between samples, s. */
  readonly start: number;
  readonly step: number;
  /** First sample that is there, and the one after the last. */
  readonly first: number;
  readonly last: number;
  has(column: string): boolean;
  cut(from: number, to: number, pixels: number): Bins;
  reduce(column: string, bins: Bins, minimum: Float32Array, maximum: Float32Array): void;
  /** The value at a time, or NaN. */
  at(column: string, time: number): number;
}

/** Returns the least and the largest of all samples of a stretch of time; NaN where there are none. */
export function extremes(
  source: SampleSource,
  column: string,
  { from, to }: Range,
): [number, number] {
  const first = Math.max(source.first, Math.round((from - source.start) / source.step));
  const last = Math.min(source.last, Math.round((to - source.start) / source.step));
  const [low, high] = [new Float32Array(1), new Float32Array(1)];
  source.reduce(column, { first, size: last - first, count: 1, paired: true }, low, high);
  return [low[0] as number, high[0] as number];
}

/** A recorded column: `x.position_reference`, `A.x.following_error`. */
export interface Channel {
  name: string;
  unit: string;
  meaning?: string;
}

/** Names of measured columns that look like expressions: `gain=1` of somebody's file. */
const measured = new Set<string>();

/** Takes the names of what was recorded: these are no expressions, whatever they look like. */
export function noteRecorded(columns: readonly string[]): void {
  for (const name of columns) if (name.includes('=')) measured.add(name);
}

/** Whether a column is computed by an expression: `name=expression`. */
export function isMath(column: string): boolean {
  return column.includes('=') && !measured.has(column);
}

/** A column computed from two others: a channel of one variant less that of another. */
export interface ColumnDifference {
  name: string;
  minuend: string;
  subtrahend: string;
}

/** The two columns that `A-B.x.thrust` is computed from; null of another name. */
export function differenceOf(column: string): ColumnDifference | null {
  const [, a, b, rest] = /^([A-Z])-([A-Z])\.([^=]+)$/.exec(column) ?? [];
  if (a === undefined || b === undefined || rest === undefined) return null;
  return { name: column, minuend: `${a}.${rest}`, subtrahend: `${b}.${rest}` };
}

/** A less B of each channel that both have. */
export function differencesOf(columns: readonly string[]): ColumnDifference[] {
  return columns
    .filter((column) => column.startsWith('A.') && columns.includes(`B.${column.slice(2)}`))
    .flatMap((column) => differenceOf(`A-B.${column.slice(2)}`) ?? []);
}

export interface Envelope {
  minimum: Float32Array;
  maximum: Float32Array;
}

let versions = 0;

/** A static result: each column as minimum and maximum of equal bins. */
export class StillSource implements SampleSource {
  readonly version = ++versions;
  readonly first = 0;
  private readonly differences = new Map<string, Envelope>();

  constructor(
    readonly start: number,
    readonly step: number,
    readonly last: number,
    private readonly columns: ReadonlyMap<string, Envelope>,
  ) {}

  has(column: string): boolean {
    return this.envelope(column) !== undefined;
  }
  /** The same, so much later, s. */
  shifted(by: number): StillSource {
    return new StillSource(this.start + by, this.step, this.last, this.columns);
  }
  cut(from: number, to: number, pixels: number): Bins {
    const low = Math.max(0, Math.floor((from - this.start) / this.step));
    const high = Math.min(this.last, Math.ceil((to - this.start) / this.step) + 1);
    // Even one stored bin has two extremes.
    return { ...cut(low, high, pixels), paired: true };
  }
  reduce(column: string, bins: Bins, minimum: Float32Array, maximum: Float32Array): void {
    const envelope = this.envelope(column);
    for (let bin = 0; bin < bins.count; bin++) {
      let least = Number.POSITIVE_INFINITY;
      let most = Number.NEGATIVE_INFINITY;
      if (envelope) {
        const begin = bins.first + bin * bins.size;
        const stop = Math.min(begin + bins.size, this.last);
        for (let i = begin; i < stop; i++) {
          const low = envelope.minimum[i] as number;
          const high = envelope.maximum[i] as number;
          if (low < least) least = low;
          if (high > most) most = high;
        }
      }
      minimum[bin] = least <= most ? least : Number.NaN;
      maximum[bin] = least <= most ? most : Number.NaN;
    }
  }
  /** A column, or the difference of two, which is computed when it is first asked for. */
  private envelope(column: string): Envelope | undefined {
    const curve = this.columns.get(column) ?? this.differences.get(column);
    if (curve) return curve;
    const { minuend, subtrahend } = differenceOf(column) ?? {};
    const a = this.columns.get(minuend ?? '');
    const b = this.columns.get(subtrahend ?? '');
    if (!a || !b) return undefined;
    const difference = middles(a, b);
    this.differences.set(column, difference);
    return difference;
  }
  at(column: string, time: number): number {
    const envelope = this.envelope(column);
    const i = Math.floor((time - this.start) / this.step);
    if (!envelope || i < 0 || i >= this.last) return Number.NaN;
    return ((envelope.minimum[i] as number) + (envelope.maximum[i] as number)) / 2;
  }
}

/** A less B at the middle of each bin: extremes of a difference do not follow from extremes. */
function middles(a: Envelope, b: Envelope): Envelope {
  const values = new Float32Array(a.minimum.length);
  for (let i = 0; i < values.length; i++) {
    const of = (e: Envelope) => ((e.minimum[i] as number) + (e.maximum[i] as number)) / 2;
    values[i] = of(a) - of(b);
  }
  return { minimum: values, maximum: values };
}
