/**
 * The last samples of each subscribed column, by tick. Plain typed arrays: nothing here is reactive.
 *
 * A sample that stands for several ticks is kept at each of them.
 *
 * Beside the samples it keeps minimum and maximum of each block of 16, aligned to multiples of 16
 * ticks, from which long windows are drawn. Ticks that never came are NaN, and are drawn as gaps.
 */

import { differencesOf } from '../../plot/source';
import { Evaluator, type Step } from '../expressions/evaluator';

const BLOCK = 16;

interface Column {
  samples: Float32Array;
  minimum: Float32Array;
  maximum: Float32Array;
}

/** A column that is computed from others as samples come. */
export interface Computed {
  column: string;
  channels: readonly string[];
  steps: readonly Step[];
}

interface Computing {
  column: Column;
  sources: readonly Column[];
  evaluator: Evaluator;
  /** The tick to compute next. */
  next: number;
}

/** Returns for how many ticks there is room if some seconds are to be kept. */
export function capacityFor(seconds: number, rate: number): number {
  return BLOCK * Math.ceil((seconds * rate) / BLOCK);
}

/** Each sample at so many ticks. */
function held(values: Float32Array, stride: number): Float32Array {
  return Float32Array.from(
    { length: values.length * stride },
    (_, i) => values[Math.floor(i / stride)] as number,
  );
}

let writes = 0;

export class Ring {
  /** Changes with every write; no two rings share a value. */
  version = ++writes;
  /** Changes with every write of ticks that were there before, and when all are forgotten. */
  revision = ++writes;
  /** First tick that is held, and the one after the last. Both equal while the ring is empty. */
  start = 0;
  end = 0;
  private readonly columns = new Map<string, Column>();
  private readonly order: Column[] = [];
  private readonly differences: [Column, Column, Column][] = [];
  private readonly computed = new Map<string, Computing>();
  /** Whether samples have changed that computed columns were computed from. */
  private stale = false;

  /** @param capacity number of ticks, a multiple of 16 */
  constructor(
    readonly capacity: number,
    readonly names: readonly string[],
  ) {
    if (capacity % BLOCK !== 0) throw new Error(`capacity ${capacity} is no multiple of ${BLOCK}`);
    for (const name of names) this.order.push(this.add(name));
    for (const { name, minuend, subtrahend } of differencesOf(names)) {
      const a = this.columns.get(minuend);
      const b = this.columns.get(subtrahend);
      if (a && b) this.differences.push([this.add(name), a, b]);
    }
  }

  has(name: string): boolean {
    return this.columns.has(name);
  }

  /** Computes these columns from now on, and from the samples that are there; no others. */
  compute(list: readonly Computed[]): void {
    const derived = list.filter(({ channels }) => channels.every((name) => this.columns.has(name)));
    for (const name of this.computed.keys()) {
      if (derived.some(({ column }) => column === name)) continue;
      this.computed.delete(name);
      this.columns.delete(name);
    }
    for (const { column: name, channels, steps } of derived) {
      if (this.columns.has(name)) continue;
      const sources = channels.map((channel) => this.columns.get(channel) as Column);
      const evaluator = new Evaluator(steps);
      this.computed.set(name, { column: this.add(name), sources, evaluator, next: this.start });
      this.version = this.revision = ++writes;
      this.stale = true;
    }
  }

  /** Returns one sample, or NaN where there is none. */
  at(name: string, tick: number): number {
    if (this.stale) this.settle();
    if (tick < this.start || tick >= this.end) return Number.NaN;
    return this.columns.get(name)?.samples[tick % this.capacity] ?? Number.NaN;
  }

  /** Forgets all samples. */
  clear(): void {
    this.version = this.revision = ++writes;
    this.start = 0;
    this.end = 0;
  }

  /**
   * Takes in one frame: `columns` in the order of the names that the ring was made with. Ticks that
   * were skipped become NaN; ticks that are there already are overwritten.
   *
   * @param stride ticks that a sample stands for; above 1, each two of them are extremes
   */
  write(tick: number, columns: readonly Float32Array[], stride = 1): void {
    const count = (columns[0]?.length ?? 0) * stride;
    if (count === 0) return;
    this.version = ++writes;
    const empty = this.end === this.start;
    if (empty || tick < this.start || tick - this.end >= this.capacity) {
      this.start = tick;
      this.end = tick;
    }
    const first = Math.min(tick, this.end);
    if (tick < this.end || empty) {
      this.stale = true;
      this.revision = ++writes;
    }
    if (tick > this.end) {
      for (const column of this.columns.values()) this.fill(column, this.end, tick);
    }
    this.store(tick, stride === 1 ? columns : columns.map((values) => held(values, stride)));
    if (stride > 1) this.flatten(tick, count, stride);
    this.end = Math.max(this.end, tick + count);
    this.start = Math.max(this.start, this.end - this.capacity);
    if (!this.stale) for (const each of this.computed.values()) this.advance(each);
    for (const column of this.columns.values()) this.summarise(column, first, tick + count);
  }

  /** Takes in a frame that comes late: only the ticks within what the ring holds. */
  patch(tick: number, columns: readonly Float32Array[]): void {
    const from = Math.max(tick, this.start);
    const to = Math.min(tick + (columns[0]?.length ?? 0), this.end);
    if (from >= to) return;
    this.version = this.revision = ++writes;
    this.store(
      from,
      columns.map((values) => values.subarray(from - tick, to - tick)),
    );
    for (const column of this.columns.values()) this.summarise(column, from, to);
    this.stale = true;
  }

  /** Computes all that is computed anew, from the oldest sample on. */
  private settle(): void {
    this.stale = false;
    for (const each of this.computed.values()) {
      each.next = -1;
      this.advance(each);
      this.summarise(each.column, this.start, this.end);
    }
  }

  /** Computes a column as far as there are samples. */
  private advance(each: Computing): void {
    const { sources, evaluator, column } = each;
    if (each.next < this.start || each.next > this.end) {
      evaluator.reset();
      each.next = this.start;
    }
    let slot = 0;
    const sample = (place: number) => (sources[place] as Column).samples[slot] as number;
    for (; each.next < this.end; each.next++) {
      slot = each.next % this.capacity;
      column.samples[slot] = evaluator.next(sample);
    }
  }

  /** Copies samples to their places and computes the differences there. */
  private store(tick: number, columns: readonly Float32Array[]): void {
    const count = columns[0]?.length ?? 0;
    for (let i = 0; i < this.order.length; i++) {
      const column = this.order[i];
      const values = columns[i];
      if (column && values) this.copy(column.samples, tick, values);
    }
    for (const [target, a, b] of this.differences) {
      for (let t = tick; t < tick + count; t++) {
        const slot = t % this.capacity;
        target.samples[slot] = (a.samples[slot] ?? Number.NaN) - (b.samples[slot] ?? Number.NaN);
      }
    }
  }

  /**
   * Reduces ticks `from` to `from + bins * size - 1` to minimum and maximum of bins of `size` ticks.
   * A bin with a missing sample among others counts the others; one without any is NaN.
   */
  reduce(
    name: string,
    from: number,
    size: number,
    bins: number,
    minimum: Float32Array,
    maximum: Float32Array,
  ): void {
    if (this.stale) this.settle();
    const column = this.columns.get(name);
    const blocks = size % BLOCK === 0 && from % BLOCK === 0;
    const step = blocks ? BLOCK : 1;
    const low = column ? (blocks ? column.minimum : column.samples) : null;
    const high = column ? (blocks ? column.maximum : column.samples) : null;
    const length = this.capacity / step;
    // In a full ring the block in which `start` lies has given its place to the newest one.
    const full = this.end - this.start === this.capacity;
    const oldest = this.start + (full ? (step - (this.start % step)) % step : 0);
    for (let bin = 0; bin < bins; bin++) {
      let least = Number.POSITIVE_INFINITY;
      let most = Number.NEGATIVE_INFINITY;
      if (low && high) {
        const begin = Math.max(from + bin * size, oldest);
        const stop = Math.min(from + (bin + 1) * size, this.end);
        for (let tick = begin - (begin % step); tick < stop; tick += step) {
          const slot = (tick / step) % length;
          const a = low[slot] as number;
          const b = high[slot] as number;
          if (a < least) least = a;
          if (b > most) most = b;
        }
      }
      minimum[bin] = least <= most ? least : Number.NaN;
      maximum[bin] = least <= most ? most : Number.NaN;
    }
  }

  /** Makes differences the middle of each bin: their extremes do not follow from extremes. */
  private flatten(tick: number, count: number, stride: number): void {
    for (const [{ samples }] of this.differences) {
      for (let bin = tick; bin < tick + count; bin += 2 * stride) {
        const first = samples[bin % this.capacity] as number;
        const second = samples[(bin + stride) % this.capacity] as number;
        for (let t = bin; t < bin + 2 * stride; t++) {
          samples[t % this.capacity] = (first + second) / 2;
        }
      }
    }
  }

  private add(name: string): Column {
    const column = {
      samples: new Float32Array(this.capacity),
      minimum: new Float32Array(this.capacity / BLOCK),
      maximum: new Float32Array(this.capacity / BLOCK),
    };
    this.columns.set(name, column);
    return column;
  }

  private copy(samples: Float32Array, tick: number, values: Float32Array): void {
    const skip = Math.max(0, values.length - this.capacity);
    const kept = skip > 0 ? values.subarray(skip) : values;
    const slot = (tick + skip) % this.capacity;
    const room = this.capacity - slot;
    if (kept.length <= room) {
      samples.set(kept, slot);
    } else {
      samples.set(kept.subarray(0, room), slot);
      samples.set(kept.subarray(room), 0);
    }
  }

  private fill(column: Column, from: number, to: number): void {
    for (let tick = Math.max(from, to - this.capacity); tick < to; tick++) {
      column.samples[tick % this.capacity] = Number.NaN;
    }
  }

  /** Renews the blocks that ticks `from` to `to - 1` touch. */
  private summarise(column: Column, from: number, to: number): void {
    const { samples, minimum, maximum } = column;
    const begin = Math.max(from, this.start);
    for (let base = begin - (begin % BLOCK); base < to; base += BLOCK) {
      // In a full ring the oldest block may have given its place to the newest one.
      if (base + this.capacity < this.end) continue;
      let least = Number.POSITIVE_INFINITY;
      let most = Number.NEGATIVE_INFINITY;
      const stop = Math.min(base + BLOCK, this.end);
      for (let tick = Math.max(base, this.start); tick < stop; tick++) {
        const value = samples[tick % this.capacity] as number;
        if (value < least) least = value;
        if (value > most) most = value;
      }
      const slot = (base / BLOCK) % (this.capacity / BLOCK);
      minimum[slot] = least <= most ? least : Number.NaN;
      maximum[slot] = least <= most ? most : Number.NaN;
    }
  }
}
