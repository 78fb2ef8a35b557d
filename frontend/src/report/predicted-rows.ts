/** Rows of numbers from what polynomials predict of them, and their residuals, to the last bit. */

const BYTES = 8;

/**
 * Adds residuals to what the numbers before predict: motionlab.reports.predicted_rows has the format.
 *
 * @param orders of each row
 * @param residuals (rows, n), of each row equal bytes of all numbers side by side
 */
export function fromResiduals(orders: readonly number[], residuals: Float64Array): Float64Array {
  const all = new Float64Array(residuals.length);
  const count = residuals.length / orders.length;
  const bytes = new Uint8Array(residuals.buffer, residuals.byteOffset, residuals.byteLength);
  orders.forEach((order, i) => {
    const row = all.subarray(i * count, (i + 1) * count);
    fill(row, order, bytes.subarray(i * count * BYTES, (i + 1) * count * BYTES));
  });
  return all;
}

function fill(row: Float64Array, order: number, planes: Uint8Array): void {
  const weights = weightsOf(order);
  const bits = new BigInt64Array(row.buffer, row.byteOffset, row.length);
  const scratch = new DataView(new ArrayBuffer(BYTES));
  for (let k = 0; k < row.length; k++) {
    for (let byte = 0; byte < BYTES; byte++) {
      scratch.setUint8(byte, planes[byte * row.length + k] as number);
    }
    const coded = scratch.getBigUint64(0, true);
    const difference = (coded >> 1n) ^ -(coded & 1n);
    let prediction = 0;
    // Sums of products in the order of the writer: other orders give other bits.
    if (k >= order) weights.forEach((weight, j) => (prediction += weight * (row[k - 1 - j] ?? 0)));
    scratch.setFloat64(0, prediction);
    bits[k] = BigInt.asIntN(64, scratch.getBigInt64(0) + difference);
  }
}

/** Of the numbers before, the nearest first: (-1)^(j + 1) binomial(order, j). */
function weightsOf(order: number): number[] {
  let weight = -1;
  return Array.from({ length: order }, (_, j) => (weight *= -(order - j) / (j + 1)));
}
