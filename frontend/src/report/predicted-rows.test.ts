import { describe, expect, it } from 'vitest';
import { fromResiduals } from './predicted-rows';

const BYTES = 8;

/** As the server writes them, for an order whose predictions are exact. */
function residualsOf(row: readonly number[], prediction: (k: number) => number): Float64Array {
  const bits = (value: number) => new BigInt64Array(new Float64Array([value]).buffer)[0] ?? 0n;
  const planes = new Uint8Array(BYTES * row.length);
  row.forEach((value, k) => {
    const difference = BigInt.asIntN(64, bits(value) - bits(prediction(k)));
    const coded = BigInt.asUintN(64, (difference << 1n) ^ (difference >> 63n));
    for (let byte = 0; byte < BYTES; byte++) {
      planes[byte * row.length + k] = Number((coded >> BigInt(8 * byte)) & 255n);
    }
  });
  return new Float64Array(planes.buffer);
}

describe('rows from residuals', () => {
  it('are the numbers themselves at order 0', () => {
    const row = [0, -0, 0.1, -1e-300, 5e-324, Number.MAX_VALUE];
    const rows = fromResiduals(
      [0],
      residualsOf(row, () => 0),
    );
    expect([...rows].every((value, k) => Object.is(value, row[k]))).toBe(true);
  });

  it('take what a polynomial predicts', () => {
    const row = [0.1, 0.3, 0.61, 1.07, 1.5];
    const before = (k: number) => row[k] as number;
    const prediction = (k: number) => (k < 2 ? 0 : 2 * before(k - 1) + -1 * before(k - 2));
    expect([...fromResiduals([2], residualsOf(row, prediction))]).toEqual(row);
  });

  it('come one after another', () => {
    const [a, b] = [residualsOf([1, 2], () => 0), residualsOf([3, 4], () => 0)];
    expect([...fromResiduals([0, 0], new Float64Array([...a, ...b]))]).toEqual([1, 2, 3, 4]);
  });
});
