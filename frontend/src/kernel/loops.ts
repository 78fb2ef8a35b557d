/** Margins of the loops of one variant, by the module: what the server answers of them, in part. */

import type { Axis } from './lanes';
import type { Memory } from './memory';
import { AXES, type About, type Exports, LANES, rowOf } from './module';

interface Margin {
  value: number;
  /** m/s; 0 at standstill. */
  velocity: number;
}

export interface StabilityAt {
  stable: boolean;
  /** Nearest gains at which that changes; null beyond a factor of 1000. */
  k_p_limit: number | null;
  k_d_limit: number | null;
}

/** Of one axis while it slides, at standstill, and where it is worst. */
export interface LoopOfAxis extends StabilityAt {
  standstill: StabilityAt;
  worst: {
    stable: boolean;
    velocity: number;
    gain_margin: Margin | null;
    phase_margin: Margin | null;
    Ms: Margin | null;
  };
}

export interface LoopOfVariant {
  /** Empty where the law has no linearisation. */
  axes: Partial<Record<Axis, LoopOfAxis>>;
  note: string | null;
}

/** Arrays of one loop, and the parameters that it was linearised with. */
interface Linearised {
  at: ReadonlyMap<string, number>;
  parameters: Float64Array | null;
}

export class LoopsInPage {
  private readonly loops = new Map<string, Linearised>();

  constructor(
    private readonly about: About,
    private readonly kernel: Exports,
    private readonly memory: Memory,
  ) {}

  /** Returns the loops of a variant with some parameters, (rows, 2), that lie at a pointer. */
  of(
    variant: string,
    parameters: Float64Array,
    at: { parameters: number; tables: number },
  ): LoopOfVariant {
    const note = this.refusal(parameters);
    if (note) return { axes: {}, note };
    const loops = AXES.map((axis) => [axis, this.ofAxis(variant, axis, parameters, at)]);
    return { axes: Object.fromEntries(loops) as LoopOfVariant['axes'], note: null };
  }

  /** Why the law of a variant has no linearisation; null where it has. */
  private refusal(parameters: Float64Array): string | null {
    const value = (name: string) => parameters[LANES * rowOf(this.about.parameters, name)] ?? 0;
    const { laws, message } = this.about.quotients;
    const rows = laws[value('compensation.law')] ?? [];
    const quotient = rows.some((row) => value(row) > 0);
    return quotient && value('compensation.enabled') > 0 ? message : null;
  }

  private ofAxis(
    variant: string,
    axis: Axis,
    parameters: Float64Array,
    pointers: { parameters: number; tables: number },
  ): LoopOfAxis {
    const lane = AXES.indexOf(axis);
    const loop = this.placed(`${variant} ${axis}`);
    const call = (name: 'linearise' | 'margins') => {
      const all = new Map([...loop.at, ...Object.entries({ ...pointers, axis: lane })]);
      this.kernel[name](...(this.about.exports[name] ?? []).map((each) => all.get(each) ?? 0));
    };
    const own = this.withoutGains(parameters, lane);
    if (!loop.parameters?.every((value, row) => Object.is(value, own[row]))) {
      loop.parameters = null; // a trap leaves arrays half written
      call('linearise');
      loop.parameters = own;
    }
    call('margins');
    return this.figures(loop.at);
  }

  /** The gains are factors in a loop that is linearised. */
  private withoutGains(parameters: Float64Array, lane: number): Float64Array {
    const { parameters: rows } = this.about;
    const own = Float64Array.from(rows, (_, row) => parameters[LANES * row + lane] as number);
    for (const gain of ['k_p', 'k_d']) own[rowOf(rows, `controller.${gain}`)] = 0;
    return own;
  }

  private placed(key: string): Linearised {
    let loop = this.loops.get(key);
    if (!loop) {
      const blocks = Object.entries(this.about.loops.blocks);
      const at = new Map(blocks.map(([name, bytes]) => [name, this.memory.place(bytes)]));
      const { speeds } = this.about.loops;
      this.memory.float64(at.get('speeds') as number, speeds.length).set(speeds);
      loop = { at, parameters: null };
      this.loops.set(key, loop);
    }
    return loop;
  }

  private figures(at: ReadonlyMap<string, number>): LoopOfAxis {
    const read = (name: string, count: number) =>
      this.memory.float64(at.get(name) as number, count).slice();
    const count = this.about.loops.speeds.length;
    const [velocity, radii] = [read('velocity', count), read('radii', count)];
    const [limits, margins] = [read('limits', 4), read('worst', 6)];
    const stability = (v: number, row: number): StabilityAt => ({
      stable: (radii[v] as number) < 1,
      k_p_limit: finite(limits[2 * row]),
      k_d_limit: finite(limits[2 * row + 1]),
    });
    const largest = radii.indexOf(Math.max(...radii));
    const stable = radii.every((radius) => radius < 1);
    const margin = (k: number): Margin | null => {
      const value = finite(margins[2 * k]);
      return stable && value !== null ? { value, velocity: margins[2 * k + 1] as number } : null;
    };
    return {
      ...stability(count - 1, 1),
      standstill: stability(0, 0),
      worst: {
        stable,
        velocity: velocity[largest] ?? 0,
        gain_margin: margin(0),
        phase_margin: margin(1),
        Ms: margin(2),
      },
    };
  }
}

function finite(value: number | undefined): number | null {
  return value !== undefined && Number.isFinite(value) ? value : null;
}
