/** Binary answers of the server: a JSON head, then curves as least and most of equal bins. */

import type { LoopOfVariant } from '../../kernel/loops';
import { type Envelope, StillSource } from '../../plot/source';
import type { Metrics } from './types';

interface Packed {
  time: { start: number; step: number; count: number };
  columns: { name: string; minimum: number; maximum: number }[];
}

/** Reads an answer; the curves, and all its numbers, are views into it. */
export function readCurves<Head extends Pick<Packed, 'time'>>(
  buffer: ArrayBuffer,
): Head & { columns: Map<string, Envelope>; numbers: Float32Array } {
  const length = new DataView(buffer).getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(buffer, 8, length));
  const head = JSON.parse(text) as Head & Packed;
  const numbers = new Float32Array(buffer, 8 + length);
  const curve = (from: number) => numbers.subarray(from, from + head.time.count);
  const columns = head.columns.map(
    ({ name, minimum, maximum }) =>
      [name, { minimum: curve(minimum), maximum: curve(maximum) }] as const,
  );
  return { ...head, columns: new Map(columns), numbers };
}

export interface Preview {
  result: Metrics;
  /** `window` when the run began at a stored state of the unchanged scenario, at `begin`. */
  how: 'whole' | 'window';
  /** s */
  begin: number;
  /** Of the whole scenario, and of a control period, s. */
  duration: number;
  period: number;
  source: StillSource;
  /** Of each variant, from the page; null where the server has to linearise. */
  loops?: Readonly<Record<string, LoopOfVariant>> | null;
}

interface Header extends Omit<Preview, 'source' | 'loops'> {
  time: { start: number; step: number; count: number };
}

/** Reads an answer of POST /whatif; arrays are views into it. */
export function readAnswer(buffer: ArrayBuffer): Preview {
  const { time, columns, result, how, begin, duration, period } = readCurves<Header>(buffer);
  const source = new StillSource(time.start, time.step, time.count, columns);
  return { result, how, begin, duration, period, source };
}
