/** The kernel's WebAssembly module: what it is called with, and whether a browser can run it. */

import type { Axis } from './lanes';

/** Rows of the arrays by name, and of which sources the module was made. */
export interface About {
  module: string;
  control_period: number;
  parameters: readonly string[];
  state: readonly string[];
  inputs: readonly string[];
  channels: readonly string[];
  tally: readonly string[];
  /** Parameters of each function by name. */
  exports: Readonly<Record<string, readonly string[]>>;
  /** Where a loop is linearised, in Stribeck velocities, and the bytes of its arrays. */
  loops: { speeds: readonly number[]; blocks: Readonly<Record<string, number>> };
  /** Parameters above 0 with which a law, by number, has no linearisation, and what is said of it. */
  quotients: { laws: readonly (readonly string[])[]; message: string };
}

/** Pointers are byte offsets in the module's memory; docs/targets.md has the arrays. */
export interface Exports {
  run(parameters: number, state: number, inputs: number, samples: number, ticks: number): void;
  run_tables(
    parameters: number,
    state: number,
    inputs: number,
    samples: number,
    tables: number,
    ticks: number,
  ): void;
  add_ticks(samples: number, inputs: number, first: number, tally: number, ticks: number): void;
  extremes(
    values: number,
    size: number,
    low: number,
    high: number,
    ticks: number,
    stride: number,
    bins: number,
  ): void;
  contour(
    path: number,
    start: number,
    following_error: number,
    kept: number,
    points: number,
    path_ticks: number,
    ticks: number,
  ): void;
  /** In the order of `About.exports`, as of `margins`. */
  linearise(...parameters: number[]): void;
  margins(...parameters: number[]): void;
}

/** x and y of one variant side by side. */
export const AXES: readonly Axis[] = ['x', 'y'];
export const LANES = 2;

/** Module of a type, a memory of one page and an operation on two float64: what the kernel needs. */
const SIMD = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15,
  253, 98, 11,
]);

/** Whether this browser has WebAssembly with 128-bit SIMD, and is allowed to compile it. */
export function hasSimd(): boolean {
  try {
    return typeof WebAssembly === 'object' && WebAssembly.validate(SIMD);
  } catch {
    return false;
  }
}

export function aboutOf(module: WebAssembly.Module): About {
  const [section] = WebAssembly.Module.customSections(module, 'motionlab');
  if (!section) throw new Error('the module says nothing of its rows');
  return JSON.parse(new TextDecoder().decode(section)) as About;
}

/** A row by its name. */
export function rowOf(names: readonly string[], name: string): number {
  const row = names.indexOf(name);
  if (row < 0) throw new Error(`the module has no row ${name}`);
  return row;
}
