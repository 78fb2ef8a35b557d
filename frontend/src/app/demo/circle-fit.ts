/** Least squares, and the circle that points lie on. */

type Values = Float64Array;

/** A circle, m. */
export interface Ring {
  x: number;
  y: number;
  radius: number;
}

/** The factors of some columns whose sum fits values best; by the normal equations. */
export function fitted(columns: readonly Values[], values: Values): number[] {
  const dot = (a: Values, b: Values) =>
    a.reduce((sum, each, i) => sum + each * (b[i] as number), 0);
  const rows = columns.map((column) => [
    ...columns.map((other) => dot(column, other)),
    dot(column, values),
  ]);
  const size = columns.length;
  for (let k = 0; k < size; k++) {
    const pivot = rows
      .slice(k)
      .reduce((a, b) => (Math.abs(b[k] ?? 0) > Math.abs(a[k] ?? 0) ? b : a));
    rows.splice(rows.indexOf(pivot), 1);
    rows.splice(k, 0, pivot);
    for (const row of rows) {
      if (row === pivot) continue;
      const factor = (row[k] as number) / (pivot[k] as number);
      for (let i = k; i <= size; i++) (row[i] as number) -= factor * (pivot[i] as number);
    }
  }
  return rows.map((row, k) => (row[size] as number) / (row[k] as number));
}

/** The circle of least squares; null for points on a line, or too close together. */
export function ringOf(x: Values, y: Values, closest: number): Ring | null {
  const mean = (values: Values) => values.reduce((sum, each) => sum + each, 0) / values.length;
  const [middleX, middleY] = [mean(x), mean(y)];
  const size = x.reduce(
    (most, value, i) => Math.max(most, Math.hypot(value - middleX, (y[i] as number) - middleY)),
    0,
  );
  if (x.length < 3 || !(size >= closest)) return null;
  const [u, v] = [
    x.map((each) => (each - middleX) / size),
    y.map((each) => (each - middleY) / size),
  ];
  const [a, b, c] = fitted(
    [u.map((each) => 2 * each), v.map((each) => 2 * each), u.map(() => 1)],
    u.map((each, i) => each ** 2 + (v[i] as number) ** 2),
  ) as [number, number, number];
  const square = c + a * a + b * b;
  if (!(square > 0) || square > FARTHEST) return null;
  return { x: middleX + size * a, y: middleY + size * b, radius: size * Math.sqrt(square) };
}

/** Of a radius over the size of its points, squared: those are on a line. */
const FARTHEST = 1e10;

/** Angles without jumps of a turn. */
export function unwrapped(angles: Values): Values {
  let turns = 0;
  return angles.map((angle, i) => {
    const step = i > 0 ? angle - (angles[i - 1] as number) : 0;
    turns -= Math.round(step / (2 * Math.PI));
    return angle + turns * 2 * Math.PI;
  });
}
