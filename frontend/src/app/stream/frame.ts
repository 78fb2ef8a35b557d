/** The binary frame of docs/stream.md. */

const MAGIC = 0x4d525350; // "PSRM" read as a little-endian number
const HEADER = 24;
const PROTOCOL = 1;
/** In place of the protocol: a frame whose samples stand for several ticks each. */
const THINNED = 2;

export interface Frame {
  sequence: number;
  /** Tick of the first sample. */
  tick: number;
  samples: number;
  /**
   * Ticks that a sample stands for. Above 1, two samples are the extremes of twice as many ticks, in
   * the order in which they came.
   */
  stride: number;
  /** One view into the message for each column, in the order of the subscription; nothing is copied. */
  columns: Float32Array[];
}

/**
 * Decodes one frame.
 *
 * @throws when the message is not a frame of this protocol
 */
export function decodeFrame(message: ArrayBuffer): Frame {
  if (message.byteLength < HEADER) throw new Error(`frame of ${message.byteLength} bytes`);
  const header = new DataView(message, 0, HEADER);
  if (header.getUint32(0, true) !== MAGIC) throw new Error('frame without its magic');
  const protocol = header.getUint16(4, true);
  if (protocol !== PROTOCOL && protocol !== THINNED)
    throw new Error(`frame of protocol ${protocol}`);
  const count = header.getUint16(6, true);
  const samples = header.getUint32(12, true);
  const begin = protocol === THINNED ? HEADER + 8 : HEADER;
  const expected = begin + 4 * count * samples;
  if (message.byteLength !== expected) {
    throw new Error(`frame of ${message.byteLength} bytes where ${expected} were announced`);
  }
  const columns: Float32Array[] = [];
  for (let i = 0; i < count; i++) {
    columns.push(new Float32Array(message, begin + 4 * i * samples, samples));
  }
  return {
    sequence: header.getUint32(8, true),
    tick: Number(header.getBigUint64(16, true)),
    samples,
    stride: protocol === THINNED ? new DataView(message).getUint32(HEADER, true) : 1,
    columns,
  };
}
