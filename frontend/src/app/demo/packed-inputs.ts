/** Lanes of a scenario from a demo's file: `motionlab demo` writes it. */

import { type Lanes, readLanes } from '../../kernel/lanes';

/** Bytes of a number, as server/demo.py writes them. */
const PLANES = 6;
const BYTE = 256;

interface Row {
  exponent: number;
  /** How many times differences were taken. */
  order: number;
}

/** Reads the lanes, and behind them each row of inputs: byte by byte, of all ticks. */
export function readPacked(buffer: ArrayBuffer): Lanes {
  const lanes = readLanes(buffer) as Lanes & { packed: Row[] };
  const { packed, first, stop } = lanes;
  const ticks = stop - first;
  const bytes = new Uint8Array(buffer, buffer.byteLength - packed.length * PLANES * ticks);
  const inputs = new Float64Array(packed.length * ticks);
  packed.forEach((row, i) => {
    const planes = bytes.subarray(i * PLANES * ticks, (i + 1) * PLANES * ticks);
    inputs.set(unpackRow(row, planes, ticks), i * ticks);
  });
  return { ...lanes, inputs, tables: lanes.tables ?? new Float64Array() };
}

function unpackRow({ exponent, order }: Row, planes: Uint8Array, ticks: number): Float64Array {
  const values = new Float64Array(ticks);
  for (let tick = 0; tick < ticks; tick++) {
    let folded = 0;
    for (let plane = PLANES - 1; plane >= 0; plane--) {
      folded = BYTE * folded + (planes[plane * ticks + tick] as number);
    }
    values[tick] = folded % 2 === 1 ? -(folded + 1) / 2 : folded / 2;
  }
  for (let turn = 0; turn < order; turn++) {
    for (let tick = 1; tick < ticks; tick++) {
      values[tick] = (values[tick] as number) + (values[tick - 1] as number);
    }
  }
  return values.map((value) => value * 2 ** exponent);
}
