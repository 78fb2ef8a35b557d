import { describe, expect, it } from 'vitest';
import fixture from '../../../../tests/fixtures/frame.bin?inline';
import { decodeFrame } from './frame';

/** Writes a frame by the byte table of docs/stream.md. */
function encode(sequence: number, tick: bigint, columns: number[][]): ArrayBuffer {
  const samples = columns[0]?.length ?? 0;
  const buffer = new ArrayBuffer(24 + 4 * columns.length * samples);
  const view = new DataView(buffer);
  [...'PSRM'].forEach((letter, i) => view.setUint8(i, letter.charCodeAt(0)));
  view.setUint16(4, 1, true);
  view.setUint16(6, columns.length, true);
  view.setUint32(8, sequence, true);
  view.setUint32(12, samples, true);
  view.setBigUint64(16, tick, true);
  columns.flat().forEach((value, i) => view.setFloat32(24 + 4 * i, value, true));
  return buffer;
}

describe('decodeFrame', () => {
  const frame = encode(41, 5_000_000_000n, [
    [1, 2, 3],
    [-0.5, Number.NaN, 1e-6],
  ]);

  it('reads header and columns', () => {
    const { sequence, tick, samples, columns } = decodeFrame(frame);
    expect([sequence, tick, samples, columns.length]).toEqual([41, 5_000_000_000, 3, 2]);
    expect([...(columns[0] ?? [])]).toEqual([1, 2, 3]);
    expect(columns[1]?.[1]).toBeNaN();
    expect(columns[1]?.[2]).toBeCloseTo(1e-6, 12);
  });
  it('copies nothing', () => {
    expect(decodeFrame(frame).columns.every((column) => column.buffer === frame)).toBe(true);
  });
  it('reads how many ticks a sample of a thinned frame stands for', () => {
    const plain = encode(3, 64n, [[1, 2]]);
    const thinned = new ArrayBuffer(plain.byteLength + 8);
    new Uint8Array(thinned).set(new Uint8Array(plain, 0, 24));
    new Uint8Array(thinned).set(new Uint8Array(plain, 24), 32);
    new DataView(thinned).setUint16(4, 2, true);
    new DataView(thinned).setUint32(24, 8, true);
    const { stride, samples, columns } = decodeFrame(thinned);
    expect([stride, samples, [...(columns[0] ?? [])]]).toEqual([8, 2, [1, 2]]);
    expect(decodeFrame(plain).stride).toBe(1);
  });
  it('takes a frame without samples', () => {
    expect(decodeFrame(encode(0, 0n, [[], []])).columns.map((c) => c.length)).toEqual([0, 0]);
  });
  it('refuses what is no frame', () => {
    expect(() => decodeFrame(new ArrayBuffer(8))).toThrow('8 bytes');
    expect(() => decodeFrame(new ArrayBuffer(24))).toThrow('magic');
    expect(() => decodeFrame(frame.slice(0, 44))).toThrow('announced');
    const other = frame.slice(0);
    new DataView(other).setUint16(4, 3, true);
    expect(() => decodeFrame(other)).toThrow('protocol 3');
  });
});

it('reads the fixture as tests/telemetry/test_frames.py does', async () => {
  const data = await (await fetch(fixture)).arrayBuffer();
  expect(data.byteLength).toBe(24 + 3 * 5 * 4);
  const { sequence, tick, samples, columns } = decodeFrame(data);
  expect([sequence, tick, samples]).toEqual([4_000_000_000, 2 ** 40 + 12_345, 5]);
  // toEqual tells -0 from 0, and takes NaN for NaN.
  expect(columns.map((column) => [...column])).toEqual([
    [0, -0, 1, -1.5, Math.fround(0.1)],
    [
      Number.POSITIVE_INFINITY,
      Number.NEGATIVE_INFINITY,
      Number.NaN,
      Math.fround(1.17549435e-38),
      Math.fround(3.4028235e38),
    ],
    [16_777_216, Math.fround(-2.0625e-5), Math.fround(1e-45), Math.fround(299_792_458), -7.25],
  ]);
});
