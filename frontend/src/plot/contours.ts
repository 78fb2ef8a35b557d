/** Lines of equal value over a grid. */

import type { Numbers } from './types';

interface Contour {
  x: (number | null)[];
  y: (number | null)[];
}

/** A side of the grid: from node (i, j) to the next one along x (0) or y (1). */
type Side = readonly [i: number, j: number, along: 0 | 1];

/**
 * Returns where values over a grid cross a level, as lines with gaps between their pieces.
 *
 * Values are straight between neighbours, places between them evenly spaced in their logarithms.
 * @param rows `rows[j][i]` at (xs[i], ys[j]); all of them numbers, infinite ones included
 */
export function contour(
  xs: readonly number[],
  ys: readonly number[],
  rows: readonly Numbers[],
  level: number,
): Contour {
  const value = (i: number, j: number) => (rows[j]?.[i] ?? Number.NaN) - level;
  const joined = new Map<string, Side[]>();
  const sides = new Map<string, Side>();
  const key = (side: Side) => side.join();
  const join = (a: Side, b: Side) => {
    for (const [one, other] of [
      [a, b],
      [b, a],
    ] as const) {
      sides.set(key(one), one);
      joined.set(key(one), [...(joined.get(key(one)) ?? []), other]);
    }
  };
  for (let j = 0; j + 1 < ys.length; j++) {
    for (let i = 0; i + 1 < xs.length; i++) {
      const corners = [value(i, j), value(i + 1, j), value(i + 1, j + 1), value(i, j + 1)];
      const round: Side[] = [
        [i, j, 0],
        [i + 1, j, 1],
        [i, j + 1, 0],
        [i, j, 1],
      ];
      const crossed = round.filter((_, k) => {
        const [a, b] = [corners[k] ?? Number.NaN, corners[(k + 1) % 4] ?? Number.NaN];
        return a < 0 !== b < 0 && !Number.isNaN(a + b);
      });
      for (let k = 0; k + 1 < crossed.length; k += 2)
        join(crossed[k] as Side, crossed[k + 1] as Side);
    }
  }
  const place = ([i, j, along]: Side): [number, number] => {
    const [k, l] = along === 0 ? [i + 1, j] : [i, j + 1];
    const [a, b] = [value(i, j), value(k, l)];
    // Half way to where there is no value to speak of.
    const share = Number.isFinite(a) && Number.isFinite(b) ? a / (a - b) : 0.5;
    const between = (from = 1, to = 1) => from * (to / from) ** share;
    return [between(xs[i], xs[k]), between(ys[j], ys[l])];
  };
  const line: Contour = { x: [], y: [] };
  const put = (x: number | null, y: number | null) => {
    line.x.push(x);
    line.y.push(y);
  };
  const take = (from: string): Side | undefined => {
    const next = joined.get(from)?.pop();
    if (!next) return undefined;
    const back = joined.get(key(next)) ?? [];
    back.splice(
      back.findIndex((side) => key(side) === from),
      1,
    );
    return next;
  };
  const ends = [...joined].filter(([, others]) => others.length === 1).map(([side]) => side);
  for (const start of [...ends, ...sides.keys()]) {
    let next = take(start);
    if (!next) continue;
    put(...place(sides.get(start) as Side));
    for (; next; next = take(key(next))) put(...place(next));
    put(null, null);
  }
  return line;
}
