/** What a report holds of its runs: the kernel's module and numbers, compressed, in base64. */

import { readLanes } from '../kernel/lanes';
import type { Inputs } from '../kernel/tasks';
import type { ReportLanes } from './copied-fields';
import { fromResiduals } from './predicted-rows';

export async function moduleOf(text: string): Promise<WebAssembly.Module> {
  return WebAssembly.compile(await inflated(text, 'gzip'));
}

/** Reads a run; inputs and tables that it leaves out are those of the run before. */
export async function recordOf(
  text: string,
  before: Inputs | null,
): Promise<{ lanes: ReportLanes; inputs: Inputs }> {
  const answer = readLanes(await inflated(text, 'deflate'));
  if ('obstacle' in answer) throw new Error(answer.obstacle);
  const lanes = answer as ReportLanes;
  const { references, first, stop, period, keys } = lanes;
  const shared = { key: keys.inputs, references, first, stop, period };
  const tables = lanes.tables ?? before?.tables ?? new Float64Array();
  if (!lanes.inputs) {
    if (!before) throw new Error('the inputs of the run are missing');
    return { lanes, inputs: { ...shared, rows: before.rows, numbers: before.numbers, tables } };
  }
  const numbers = fromResiduals(lanes.orders, lanes.inputs);
  return { lanes, inputs: { ...shared, rows: lanes.rows, numbers, tables } };
}

async function inflated(text: string, format: CompressionFormat): Promise<ArrayBuffer> {
  const bytes = Uint8Array.from(atob(text.trim()), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream(format));
  return new Response(stream).arrayBuffer();
}
