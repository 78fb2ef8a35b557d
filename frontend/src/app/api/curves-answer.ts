/** Binary answers of the server: a JSON head, then curves as least and most of equal bins. */

import { differenceName, type Envelope } from '../../plot/source';

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

/** Adds the following errors of A less those of B, where both are there. */
export function addDifferences(columns: Map<string, Envelope>): void {
  for (const axis of ['x', 'y']) {
    const a = columns.get(`A.${axis}.following_error`);
    const b = columns.get(`B.${axis}.following_error`);
    if (!a || !b) continue;
    columns.set(differenceName(`${axis}.following_error`, 'A', 'B'), middles(a, b));
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
