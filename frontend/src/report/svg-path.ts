/** Curves as paths of SVG. */

/**
 * Returns a path through the least and the largest value of each bin; NaN is a gap. Of the two, the one
 * nearer to where the path is comes first.
 *
 * @param x, low, high places of a bin
 */
export function pathOf(
  bins: number,
  x: (bin: number) => number,
  low: (bin: number) => number,
  high: (bin: number) => number,
): string {
  const steps: string[] = [];
  let [pen, before] = [false, 0];
  for (let bin = 0; bin < bins; bin++) {
    let [first, second] = [low(bin), high(bin)];
    if (!Number.isFinite(first + second)) {
      pen = false;
      continue;
    }
    if (pen && Math.abs(second - before) < Math.abs(first - before)) {
      [first, second] = [second, first];
    }
    const [begin, end] = [short(first), short(second)];
    steps.push(`${pen ? 'L' : 'M'}${short(x(bin))} ${begin}`);
    if (begin !== end) steps.push(`V${end}`);
    [pen, before] = [true, second];
  }
  return steps.join('');
}

function short(value: number): string {
  return String(Math.round(100 * value) / 100);
}
