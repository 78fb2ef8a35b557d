/** Messages between the page and a worker that runs the kernel. */

import type { Axis, WindowHead } from './lanes';
import type { LoopOfVariant } from './loops';
import type { Figures } from './metrics';

/** What runs share while only parameters change. */
export interface Inputs {
  /** Names these inputs and tables. */
  key: string;
  /** Ticks [first, stop) of the scenario. */
  first: number;
  stop: number;
  /** s */
  period: number;
  rows: readonly [name: string, axis: Axis][];
  /** (rows, ticks) */
  numbers: Float64Array;
  tables: Float64Array;
  /** Column to the row that holds it. */
  references: Readonly<Record<string, string>>;
}

/** One column of a variant, or of the references, which are every variant's. */
export interface Column {
  channel: string;
  axis: Axis;
}

/** Equal bins over ticks [from, to) of the scenario. */
export interface Bins {
  from: number;
  to: number;
  size: number;
}

export interface Run {
  variant: string;
  /** From which tick of the scenario parameters hold, (parameters, 2). */
  epochs: readonly { from: number; parameters: Float64Array }[];
  /** (rows, 2) */
  state: Float64Array;
  tabled: boolean;
  /** Whether its loops are linearised. */
  linear: boolean;
  windows: readonly Pick<WindowHead, 'start' | 'end' | 'settling_band' | 'holds'>[];
  moving: readonly Axis[];
  columns: readonly Column[];
  bins: Bins;
}

export interface Curve {
  minimum: Float32Array<ArrayBuffer>;
  maximum: Float32Array<ArrayBuffer>;
}

export interface Divergence {
  time: number;
  channel: string;
  last_states: Record<string, number | string>[];
}

export interface WindowFigures {
  axes: Partial<Record<Axis, Figures>>;
  contour: Figures;
}

export interface RunResult {
  /** null where none are asked for. */
  loops: LoopOfVariant | null;
  diverged: Divergence | null;
  windows: WindowFigures[];
  curves: Curve[];
}

export type Request =
  | { kind: 'open'; module: WebAssembly.Module; most: number }
  | { kind: 'inputs'; inputs: Inputs }
  | { kind: 'run'; run: Run }
  | { kind: 'curves'; variant: string; columns: readonly Column[]; bins: Bins };

export type Answer = RunResult | Curve[] | null;

export interface Envelope {
  id: number;
  request: Request;
}

export type Reply = { id: number } & ({ answer: Answer } | { error: string });
