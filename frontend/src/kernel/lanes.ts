/** A what-if as numbers: the server's answer to POST /whatif/lanes. */

const SPACE = 0x20;

export type Axis = 'x' | 'y';

/** Start and end in ticks from the window's start, and the length of the move before, m. */
export type Hold = readonly [start: number, end: number, move: number];

export interface WindowHead {
  /** Ticks of the scenario. */
  start: number;
  end: number;
  settling_band: number;
  holds: Partial<Record<Axis, Hold[]>>;
  variants: Record<string, { label: string; law: string; enabled: boolean; notes: string[] }>;
}

interface Place {
  first: number;
  shape: number[];
}

export interface LanesHead {
  /** Hash of the sources of the module that computes what the server does. */
  module: string;
  result: Record<string, unknown>;
  how: 'whole' | 'window';
  period: number;
  /** Of the whole scenario. */
  ticks: number;
  /** Ticks [first, stop) run. */
  first: number;
  stop: number;
  epochs: number[];
  tabled: boolean[];
  keys: { inputs: string; tables: string };
  rows: [name: string, axis: Axis][];
  references: Record<string, string>;
  moving: Axis[];
  windows: WindowHead[];
  segments: number[];
  /** Metrics that are compared. */
  ratios: string[];
}

export interface Lanes extends LanesHead {
  /** (epochs, variants, parameters, 2), and (variants, rows, 2). */
  lanes: Float64Array;
  state: Float64Array;
  /** (rows, ticks), and tables; null where they are known. */
  inputs: Float64Array | null;
  tables: Float64Array | null;
}

export type LanesAnswer = Lanes | { obstacle: string };

/** Reads an answer; arrays are views into it. */
export function readLanes(buffer: ArrayBuffer): LanesAnswer {
  const length = new DataView(buffer).getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(buffer, 8, length));
  const head = JSON.parse(text) as
    { obstacle: string } | (LanesHead & { arrays: Record<string, Place> });
  if ('obstacle' in head) return head;
  const { arrays, ...rest } = head;
  const numbers = new Float64Array(buffer, 8 + length);
  const view = (name: string): Float64Array | null => {
    const place = arrays[name];
    if (!place) return null;
    const size = place.shape.reduce((product, each) => product * each, 1);
    return numbers.subarray(place.first, place.first + size);
  };
  const [lanes, state] = [view('lanes'), view('state')];
  if (!lanes || !state) throw new Error('lanes or state are missing');
  return { ...rest, lanes, state, inputs: view('inputs'), tables: view('tables') };
}

/** Writes an answer as the server does. */
export function packLanes({ lanes, state, inputs, tables, ...head }: Lanes): ArrayBuffer {
  const parts = Object.entries({ lanes, state, inputs, tables }).flatMap(([name, numbers]) =>
    numbers ? [{ name, numbers }] : [],
  );
  let end = 0;
  const arrays = Object.fromEntries(
    parts.map(({ name, numbers: { length } }) => {
      end += length;
      return [name, { first: end - length, shape: [length] }];
    }),
  );
  const text = new TextEncoder().encode(JSON.stringify({ ...head, arrays }));
  const bytes = new Uint8Array(Math.ceil(text.length / 8) * 8).fill(SPACE);
  bytes.set(text);
  const buffer = new ArrayBuffer(8 + bytes.length + 8 * end);
  new DataView(buffer).setUint32(0, bytes.length, true);
  new Uint8Array(buffer, 8).set(bytes);
  const values = new Float64Array(buffer, 8 + bytes.length);
  for (const { name, numbers } of parts) values.set(numbers, arrays[name]?.first ?? 0);
  return buffer;
}
