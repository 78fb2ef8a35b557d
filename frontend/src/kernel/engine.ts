/** The kernel with what lies in its memory: the inputs, and every sample of the latest runs. */

import type { Axis } from './lanes';
import { type LoopOfVariant, LoopsInPage } from './loops';
import { Memory } from './memory';
import { AXES, type About, aboutOf, type Exports, LANES, rowOf } from './module';
import { divergenceOf } from './divergence';
import { holdMetrics, NO_METRICS, tallyMetrics } from './metrics';
import type { Bins, Column, Curve, Inputs, Run, RunResult, WindowFigures } from './tasks';

/** Of a path that is prolonged, m: further than a contour's search goes. */
const BEYOND = 1;
/** Numbers of the nearest point of a path; its distance comes first. */
const POINT = 6;
const BYTES = 8;
/** Numbers that are read and discarded where there are no tables. */
const UNREAD = 64;

/** Of one variant. */
interface Slot {
  parameters: number;
  state: number;
  samples: number;
}

export class Engine {
  readonly about: About;
  private readonly kernel: Exports;
  private readonly memory: Memory;
  private inputs: Inputs | null = null;
  private slots = new Map<string, Slot>();
  private loops: LoopsInPage;
  /** Pointers of what runs share. */
  private at = { inputs: 0, tables: 0, path: 0 };
  /** Points of the path, and those before the first tick. */
  private path = { points: 0, before: 0 };

  constructor(module: WebAssembly.Module, most: number) {
    this.about = aboutOf(module);
    this.memory = new Memory(most);
    const { exports } = new WebAssembly.Instance(module, { env: { memory: this.memory.memory } });
    this.kernel = exports as unknown as Exports;
    this.loops = new LoopsInPage(this.about, this.kernel, this.memory);
  }

  get bytes(): number {
    return this.memory.bytes;
  }

  /** Takes the inputs of the runs to come; samples of runs before are gone. */
  take(inputs: Inputs): void {
    this.inputs = null;
    this.slots = new Map();
    this.memory.release();
    this.loops = new LoopsInPage(this.about, this.kernel, this.memory);
    const none = inputs.tables.length === 0;
    const tables = this.memory.put(none ? new Float64Array(UNREAD) : inputs.tables);
    this.at = { tables, inputs: this.putInputs(inputs), path: this.putPath(inputs) };
    this.inputs = inputs;
  }

  /** Runs one variant. */
  run(run: Run): RunResult {
    const { inputs, kernel, about, at } = this;
    if (!inputs) throw new Error('there are no inputs');
    const slot = this.slot(run.variant, inputs);
    const state = this.memory.float64(slot.state, about.state.length * LANES);
    state.set(run.state);
    run.epochs.forEach(({ from, parameters }, i) => {
      const [start, end] = [Math.max(from, inputs.first), run.epochs[i + 1]?.from ?? inputs.stop];
      this.memory.float64(slot.parameters, parameters.length).set(parameters);
      const [row, sample] = [this.inputAt(start), this.sampleAt(slot, start)];
      const ticks = end - start;
      if (run.tabled) {
        kernel.run_tables(slot.parameters, slot.state, row, sample, at.tables, ticks);
      } else kernel.run(slot.parameters, slot.state, row, sample, ticks);
    });
    const failed = rowOf(about.state, 'failed') * LANES;
    const ended = [state[failed], state[failed + 1]].filter(
      (tick) => tick !== undefined && tick >= 0,
    );
    const diverged = ended.length > 0 ? Math.min(...(ended as number[])) : null;
    return {
      loops: run.linear ? this.linearised(slot, run) : null,
      diverged: diverged === null ? null : this.end(slot, diverged, inputs),
      windows: run.windows.map((window) =>
        diverged === null ? this.figures(slot, run, window, inputs) : noFigures(run.moving),
      ),
      curves: this.curves(run.variant, run.columns, run.bins),
    };
  }

  /** Reads columns of the latest run of a variant. */
  curves(variant: string, columns: readonly Column[], bins: Bins): Curve[] {
    const { inputs } = this;
    const slot = this.slots.get(variant);
    if (!inputs || !slot) throw new Error(`variant ${variant} has not run`);
    return columns.map(({ channel, axis }) => {
      const row = inputs.references[channel];
      return row === undefined
        ? this.extremes(slot, channel, axis, bins)
        : this.reference(inputs, row, axis, bins);
    });
  }

  /** Of a run in which no parameter changes. */
  private linearised({ parameters }: Slot, { variant, epochs }: Run): LoopOfVariant | null {
    const pointers = { parameters, tables: this.at.tables };
    return epochs[0] ? this.loops.of(variant, epochs[0].parameters, pointers) : null;
  }

  private get stride(): number {
    return this.about.channels.length * LANES;
  }

  private inputAt(tick: number): number {
    const rows = this.about.inputs.length * LANES;
    return this.at.inputs + BYTES * rows * (tick - (this.inputs?.first ?? 0));
  }

  private sampleAt(slot: Slot, tick: number, channel = '', axis: Axis = 'x'): number {
    const column = channel === '' ? 0 : LANES * rowOf(this.about.channels, channel);
    const index = (tick - (this.inputs?.first ?? 0)) * this.stride + column + AXES.indexOf(axis);
    return slot.samples + Float32Array.BYTES_PER_ELEMENT * index;
  }

  private slot(variant: string, { first, stop }: Inputs): Slot {
    let slot = this.slots.get(variant);
    if (!slot) {
      const { parameters, state } = this.about;
      slot = {
        parameters: this.memory.place(BYTES * LANES * parameters.length),
        state: this.memory.place(BYTES * LANES * state.length),
        samples: this.memory.place(Float32Array.BYTES_PER_ELEMENT * this.stride * (stop - first)),
      };
      this.slots.set(variant, slot);
    }
    return slot;
  }

  private putInputs({ rows, numbers, first, stop }: Inputs): number {
    const { inputs } = this.about;
    const [ticks, stride] = [stop - first, inputs.length * LANES];
    const pointer = this.memory.place(BYTES * stride * ticks);
    const all = this.memory.float64(pointer, stride * ticks).fill(0);
    rows.forEach(([name, axis], i) => {
      const row = inputs.indexOf(name);
      if (row < 0) return;
      let place = row * LANES + AXES.indexOf(axis);
      for (const value of numbers.subarray(i * ticks, (i + 1) * ticks)) {
        all[place] = value;
        place += stride;
      }
    });
    return pointer;
  }

  /** Places the path with a straight line at each end at which it moves. */
  private putPath({ rows, numbers, first, stop }: Inputs): number {
    const ticks = stop - first;
    const pointer = this.memory.place(BYTES * LANES * (ticks + 2));
    const all = this.memory.float64(pointer, LANES * (ticks + 2)).fill(0);
    const at = (tick: number) =>
      AXES.map((axis) => {
        const row = rows.findIndex(([name, each]) => name === 'p_ref' && each === axis);
        return row < 0 ? 0 : (numbers[row * ticks + tick] as number);
      }) as [number, number];
    const into = ticks > 1 ? straight(at(0), at(1)) : null;
    const out = ticks > 1 ? straight(at(ticks - 2), at(ticks - 1)) : null;
    let points = 0;
    const add = (
      [x, y]: readonly [number, number],
      [dx, dy]: readonly [number, number] = [0, 0],
    ) => {
      all[LANES * points] = x + dx;
      all[LANES * points + 1] = y + dy;
      points += 1;
    };
    if (into) add(at(0), [-into[0], -into[1]]);
    for (let tick = 0; tick < ticks; tick++) add(at(tick));
    if (out) add(at(ticks - 1), out);
    this.path = { points, before: into ? 1 : 0 };
    return pointer;
  }

  /** Ends the curves of a variant that has diverged. */
  private end(slot: Slot, tick: number, { first, stop, period }: Inputs) {
    const { stride, about } = this;
    const samples = this.memory.float32(slot.samples, stride * (stop - first));
    const divergence = divergenceOf(samples, about.channels, tick - first);
    samples.fill(Number.NaN, (tick - first) * stride);
    return { time: tick * period, ...divergence };
  }

  private figures(
    slot: Slot,
    run: Run,
    { start, end, settling_band, holds }: Run['windows'][number],
    { period }: Inputs,
  ): WindowFigures {
    const { memory, about } = this;
    const { mark } = memory;
    const ticks = end - start;
    const distances = this.contour(slot, start, ticks);
    const numbers = about.tally.length * LANES;
    const pointer = memory.place(BYTES * numbers);
    const tally = memory.float64(pointer, numbers).fill(0);
    const row = (name: string) => rowOf(about.tally, name) * LANES;
    tally.fill(Number.POSITIVE_INFINITY, row('error_min'), row('error_min') + LANES);
    tally.fill(Number.NEGATIVE_INFINITY, row('error_max'), row('error_max') + LANES);
    this.kernel.add_ticks(this.sampleAt(slot, start), this.inputAt(start), 0, pointer, ticks);
    const axes = run.moving.map((axis) => {
      const lane = AXES.indexOf(axis);
      const error = memory.float32(
        this.sampleAt(slot, start, 'following_error', axis),
        (ticks - 1) * this.stride + 1,
      );
      const figures = {
        ...tallyMetrics((name) => tally[row(name) + lane] as number, ticks, period),
        ...holdMetrics(
          (tick) => error[tick * this.stride] as number,
          holds[axis] ?? [],
          settling_band,
          period,
        ),
      };
      return [axis, figures] as const;
    });
    memory.release(mark);
    return { axes: Object.fromEntries(axes), contour: distances };
  }

  /** Returns the largest and the mean square distance from the path. */
  private contour(slot: Slot, start: number, ticks: number): { max: number; rms: number } {
    const { memory, path } = this;
    const { mark } = memory;
    const kept = memory.place(BYTES * path.points);
    const points = memory.place(BYTES * POINT * ticks);
    const error = this.sampleAt(slot, start, 'following_error');
    const first = path.before + start - (this.inputs?.first ?? 0);
    this.kernel.contour(this.at.path, first, error, kept, points, path.points, ticks);
    const numbers = memory.float64(points, POINT * ticks);
    let [max, squares] = [0, 0];
    for (let i = 0; i < numbers.length; i += POINT) {
      const distance = numbers[i] as number;
      if (distance > max) max = distance;
      squares += distance * distance;
    }
    memory.release(mark);
    return { max, rms: Math.sqrt(squares / ticks) };
  }

  private extremes(slot: Slot, channel: string, axis: Axis, { from, to, size }: Bins): Curve {
    const { memory, stride } = this;
    const { mark } = memory;
    const count = Math.ceil((to - from) / size);
    const low = memory.place(Float32Array.BYTES_PER_ELEMENT * count);
    const high = memory.place(Float32Array.BYTES_PER_ELEMENT * count);
    const values = this.sampleAt(slot, from, channel, axis);
    this.kernel.extremes(values, size, low, high, to - from, stride, count);
    const curve = {
      minimum: memory.float32(low, count).slice(),
      maximum: memory.float32(high, count).slice(),
    };
    memory.release(mark);
    return curve;
  }

  private reference(inputs: Inputs, row: string, axis: Axis, { from, to, size }: Bins): Curve {
    const { rows, numbers, first, stop } = inputs;
    const place = rows.findIndex(([name, each]) => name === row && each === axis);
    const count = Math.ceil((to - from) / size);
    const [minimum, maximum] = [new Float32Array(count), new Float32Array(count)];
    if (place < 0) return { minimum, maximum };
    const values = numbers.subarray(place * (stop - first), (place + 1) * (stop - first));
    for (let bin = 0; bin < count; bin++) {
      const begin = from - first + bin * size;
      let [low, high] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
      for (let i = begin; i < Math.min(begin + size, to - first); i++) {
        const value = values[i] as number;
        if (value < low) low = value;
        if (value > high) high = value;
      }
      [minimum[bin], maximum[bin]] = [low, high];
    }
    return { minimum, maximum };
  }
}

/** The straight continuation of a path by two of its points; null at rest. */
function straight(
  a: readonly [number, number],
  b: readonly [number, number],
): [number, number] | null {
  const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
  const length = Math.hypot(dx, dy);
  return length > 0 ? [(BEYOND * dx) / length, (BEYOND * dy) / length] : null;
}

function noFigures(moving: readonly Axis[]): WindowFigures {
  const axes = Object.fromEntries(moving.map((axis) => [axis, NO_METRICS]));
  return { axes, contour: { max: null, rms: null } };
}
