/** The answer of POST /runs/compare/window: one channel of both runs, in bins of equal instants. */

import { extent } from '../../plot/axis-scale';
import type { Range } from '../../plot/range';

export type CurveName = 'baseline' | 'candidate' | 'difference' | 'tolerance' | 'beyond';

interface Head {
  instants: { start: number; step: number; count: number; total: number };
  axis: {
    name: 'time' | 'reference' | 'index';
    unit: string;
    start: number;
    lap_length: number | null;
    values: number;
  };
  columns: { name: CurveName; unit: string; minimum: number; maximum: number }[];
}

interface Envelope {
  minimum: Float32Array;
  maximum: Float32Array;
}

export class ComparisonWindow {
  /** Where each bin begins: time of 1, arc length over all laps, or sample. */
  readonly x: Float64Array;
  readonly unit: string;
  private readonly curves: ReadonlyMap<CurveName, Envelope>;

  constructor(
    readonly instants: Head['instants'],
    readonly axis: Head['axis'],
    numbers: Float32Array,
    columns: Head['columns'],
  ) {
    const { count } = instants;
    const cut = (from: number) => numbers.subarray(from, from + count);
    this.x = Float64Array.from(cut(axis.values), (value) => axis.start + value);
    this.unit = columns.find(({ name }) => name === 'baseline')?.unit ?? '1';
    this.curves = new Map(
      columns.map(({ name, minimum, maximum }) => [
        name,
        { minimum: cut(minimum), maximum: cut(maximum) },
      ]),
    );
  }

  static read(buffer: ArrayBuffer): ComparisonWindow {
    const length = new DataView(buffer).getUint32(0, true);
    const text = new TextDecoder().decode(new Uint8Array(buffer, 8, length));
    const { instants, axis, columns } = JSON.parse(text) as Head;
    return new ComparisonWindow(instants, axis, new Float32Array(buffer, 8 + length), columns);
  }

  curve(name: CurveName): Envelope {
    return this.curves.get(name) ?? { minimum: new Float32Array(), maximum: new Float32Array() };
  }

  /** Least and largest value of some curves; null where there is none. */
  extent(...names: CurveName[]) {
    const all = names.map((name) => this.curve(name));
    return extent(all.flatMap(({ minimum, maximum }) => [...minimum, ...maximum]));
  }

  /** Bin at a place of the axis. */
  bin(x: number): number {
    let [low, high] = [0, this.x.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if ((this.x[middle] as number) <= x) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  /** Instants [from, to) between two places of the axis. */
  instantsOf({ from, to }: Range): Range {
    const { start, step, count } = this.instants;
    const last = Math.min(this.bin(to) + 1, count);
    return { from: start + this.bin(from) * step, to: start + last * step };
  }

  /** Bins [from, to) one after the other in which something is beyond the tolerance. */
  excursions(): Range[] {
    const { maximum } = this.curve('beyond');
    const ranges: Range[] = [];
    for (let i = 0; i < maximum.length; i++) {
      const from = i;
      while (i < maximum.length && maximum[i] === 1) i++;
      if (i > from) ranges.push({ from, to: i });
    }
    return ranges;
  }
}
