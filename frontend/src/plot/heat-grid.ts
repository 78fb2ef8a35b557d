/** What HeatMap draws of its grid: which cell a pixel belongs to, and the picture of all cells. */

import { AxisScale, extent, type Extent } from './axis-scale';
import type { Line, Numbers, PlotAxis, Series, Spot } from './types';

/** Values of a grid, row by row along y: null and NaN are cells without a value. */
export type Rows = readonly ArrayLike<number | null>[];

export interface ColourAxis extends PlotAxis {
  /** Centre of a diverging map, as far up as down. */
  centre?: number;
}

/** Edges of cells around their centres: half way between neighbours, on the scale of the axis. */
export function edges(centres: ArrayLike<number>, log = false): number[] {
  const warp = (value: number) => (log ? Math.log10(value) : value);
  const back = (value: number) => (log ? 10 ** value : value);
  const at = Array.from(centres, warp);
  const first = at[0];
  if (first === undefined) return [];
  if (at.length === 1) {
    const half = log ? 0.15 : Math.max(Math.abs(first) * 0.5, 0.5);
    return [back(first - half), back(first + half)];
  }
  const between = at.slice(1).map((value, i) => (value + (at[i] ?? value)) / 2);
  const outer = (end: number, next: number) => end + (end - next);
  return [
    outer(first, between[0] ?? first),
    ...between,
    outer(at[at.length - 1] ?? first, between[between.length - 1] ?? first),
  ].map(back);
}

/** Index of the cell that holds a value, -1 outside. */
export function cellAt(between: readonly number[], value: number): number {
  const last = between.length - 1;
  if (last < 1 || !(value >= (between[0] as number) && value <= (between[last] as number)))
    return -1;
  let [low, high] = [0, last];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if ((between[middle] as number) <= value) low = middle;
    else high = middle;
  }
  return low;
}

function* values(rows: Rows): Generator<number | null> {
  for (const row of rows) for (let i = 0; i < row.length; i++) yield row[i] ?? null;
}

/** Ends of the colour axis. */
export function colourRange(z: ColourAxis, rows: Rows): Extent {
  const range = extent(values(rows), z.log) ?? {
    low: z.log === true ? 1 : 0,
    high: z.log === true ? 10 : 1,
  };
  let [low, high] = [z.from ?? range.low, z.to ?? range.high];
  if (z.centre !== undefined) {
    const far = Math.max(high - z.centre, z.centre - low);
    [low, high] = [z.centre - far, z.centre + far];
  }
  if (low === high) [low, high] = z.log === true ? [low / 2, high * 2] : [low - 0.5, high + 0.5];
  return { low, high };
}

export function isEmpty(rows: Rows): boolean {
  return extent(values(rows)) === null;
}

/** First and last edge of an axis. */
export function spanOf(between: readonly number[]): Extent | null {
  const [low, high] = [between[0], between[between.length - 1]];
  return low === undefined || high === undefined ? null : { low, high };
}

const WAYS: Record<string, [number, number]> = {
  ArrowRight: [1, 0],
  ArrowLeft: [-1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
};

/** The cell that an arrow key leads to, from the middle at first; null for another key. */
export function moved(
  from: { i: number; j: number } | null,
  key: string,
  by: number,
  columns: number,
  rows: number,
): { i: number; j: number } | null {
  const way = WAYS[key];
  if (!way) return null;
  if (!from) return { i: Math.floor(columns / 2), j: Math.floor(rows / 2) };
  const within = (at: number, count: number) => Math.min(count - 1, Math.max(0, at));
  return { i: within(from.i + by * way[0], columns), j: within(from.j + by * way[1], rows) };
}

/** The colour axis as a scale over `height` pixels, upwards. */
export function colourScale(z: ColourAxis, { low, high }: Extent, height: number): AxisScale {
  return new AxisScale(z, low, high, [height, 0]);
}

export interface Painting {
  width: number;
  height: number;
  /** Cell of each column of pixels and of each row of pixels; -1 is outside of the grid. */
  columns: Int32Array;
  lines: Int32Array;
  rows: Rows;
  colours: Uint32Array;
  /** Share 0 to 1 along the colour axis; NaN where there is no value. */
  share: (value: number | null | undefined) => number;
  /** Cells that are drawn faint and hatched. */
  region?: readonly (readonly boolean[])[] | undefined;
  /** Pixels of cells without a value: ground and hatching. */
  ground: number;
  hatch: number;
}

/** Cell of each pixel along one axis. */
export function cellsOf(
  axis: AxisScale,
  between: readonly number[],
  start: number,
  pixels: number,
  dpr: number,
) {
  return Int32Array.from({ length: pixels }, (_, i) =>
    cellAt(between, axis.at(start + (i + 0.5) / dpr)),
  );
}

/** Share of the ground in cells that are drawn faint. */
const FAINT = 0.62;

/** A pixel between two, `share` of the second. */
function mixed(one: number, other: number, share: number): number {
  let pixel = 0;
  for (let shift = 24; shift >= 0; shift -= 8) {
    const [a, b] = [(one >>> shift) & 255, (other >>> shift) & 255];
    pixel = pixel * 256 + Math.round(a + (b - a) * share);
  }
  return pixel;
}

/** Fills an image, 32-bit pixels row by row from the top. */
export function paint(image: Uint32Array, painting: Painting): void {
  const { width, height, columns, lines, rows, colours, share, region, ground, hatch } = painting;
  const faint = region ? colours.map((colour) => mixed(colour, ground, FAINT)) : colours;
  const top = colours.length - 1;
  const across = Math.max(0, ...rows.map((row) => row.length));
  // A cell is looked up once, not for each of its pixels.
  const shades = rows.map((row) =>
    Int32Array.from({ length: across }, (_, i) => {
      const at = share(row[i]);
      return Number.isFinite(at) ? Math.round(Math.min(1, Math.max(0, at)) * top) : -1;
    }),
  );
  for (let j = 0; j < height; j++) {
    const row = shades[lines[j] as number];
    const outside = region?.[lines[j] as number];
    for (let i = 0; i < width; i++) {
      const cell = columns[i] as number;
      const shade = row && cell >= 0 ? (row[cell] ?? -1) : -2;
      if (shade >= 0 && outside?.[cell]) {
        image[j * width + i] = (i - j + height) % 10 < 2 ? hatch : (faint[shade] as number);
        continue;
      }
      image[j * width + i] =
        shade >= 0 ? (colours[shade] as number) : shade === -1 && (i + j) % 8 < 2 ? hatch : ground;
    }
  }
}

/** Entries of the legend for lines: one for each, or one for a family. */
export function lineKeys(lines: readonly Line[]): Series[] {
  const byName = new Map<string, Series>();
  for (const line of lines) {
    const name = line.family ?? line.name;
    if (!byName.has(name)) byName.set(name, { ...line, name, kind: 'line' });
  }
  return [...byName.values()];
}

/** Entries of the legend for points: one for each, or one for a family. */
export function keysOf(points: readonly Spot[]): Series[] {
  const byKey = new Map<string, Series>();
  for (const { name, family, ink, marker = 'circle' } of points) {
    const key = family ?? name;
    if (byKey.has(key)) continue;
    byKey.set(key, { name: key, x: [], y: [], kind: 'points', marker, ...(ink ? { ink } : {}) });
  }
  return [...byKey.values()];
}

/** Every so many columns or rows of a table, so that at most `most` are left. */
export function thin(count: number, most: number): number[] {
  const every = Math.max(1, Math.ceil(count / most));
  return Array.from({ length: count }, (_, i) => i).filter((i) => i % every === 0);
}

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
