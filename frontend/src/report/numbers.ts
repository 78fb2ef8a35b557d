/** What a report holds of its runs: the kernel's module and numbers, compressed, in base64. */

import { type Lanes, readLanes } from '../kernel/lanes';
import type { Inputs } from '../kernel/tasks';
import { fromResiduals } from './predicted-rows';

export async function moduleOf(text: string): Promise<WebAssembly.Module> {
  return WebAssembly.compile(await inflated(text, 'gzip'));
}

/** Reads a run, its inputs from their residuals. */
export async function lanesOf(text: string): Promise<Lanes & { inputs: Float64Array }> {
  const lanes = readLanes(await inflated(text, 'deflate'));
  if ('obstacle' in lanes || !lanes.inputs) throw new Error('the numbers of the run are missing');
  const { orders } = lanes as unknown as { orders: number[] };
  return { ...lanes, inputs: fromResiduals(orders, lanes.inputs) };
}

export function inputsOf(lanes: Lanes & { inputs: Float64Array }): Inputs {
  const { rows, references, first, stop, period, inputs, tables, keys } = lanes;
  const numbers = { numbers: inputs, tables: tables ?? new Float64Array() };
  return { key: keys.inputs, rows, references, first, stop, period, ...numbers };
}

async function inflated(text: string, format: CompressionFormat): Promise<ArrayBuffer> {
  const bytes = Uint8Array.from(atob(text.trim()), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream(format));
  return new Response(stream).arrayBuffer();
}
