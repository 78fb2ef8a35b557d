/** The table twin of a plot: the numbers that are drawn. */

import type { AxisScale } from './axis-scale';
import { ascending, errorEnds, finite } from './curves';
import type { Band, Look, Numbers, Series } from './types';

export interface Column {
  name: string;
  unit: string;
  cells: string[];
  /** Of the curve that it has the numbers of, where others are like it. */
  look?: Look;
}

/** More rows than these could not be read; of longer curves every so many points are shown. */
const MOST = 200;

/** Columns of the table: one x for all, or for curves that run to and fro an x of their own. */
export function columnsOf(
  series: readonly Series[],
  bands: readonly Band[],
  x: AxisScale,
  y: AxisScale,
): { columns: Column[]; thinned: boolean } {
  const lines = [...series.flatMap(linesOf), ...bands.flatMap(edgesOf)];
  const joined = lines.every((line) => ascending(line.x));
  const all = joined ? places(lines) : [];
  const length = joined ? all.length : Math.max(0, ...lines.map((line) => line.x.length));
  const every = Math.max(1, Math.ceil(length / MOST));
  const kept = (i: number) => i % every === 0 || i === length - 1;
  const head = (name: string, axis: AxisScale, cells: string[]) => ({
    name,
    unit: axis.shown.unit,
    cells,
  });
  const columns: Column[] = [];
  if (joined) {
    const rows = all.filter((_, i) => kept(i));
    columns.push(head(x.label, x, rows.map((value) => x.text(value)))); // prettier-ignore
    for (const line of lines) {
      const at = new Map(pairs(line));
      columns.push(head(line.name, y, rows.map((value) => cell(at.get(value), y)))); // prettier-ignore
    }
  } else {
    const index = Array.from({ length }, (_, i) => i).filter(kept);
    for (const line of lines) {
      const name = lines.length > 1 ? `${line.name}: ${x.label}` : x.label;
      columns.push(head(name, x, index.map((i) => cell(line.x[i], x)))); // prettier-ignore
      columns.push(head(line.name, y, index.map((i) => cell(line.y[i], y)))); // prettier-ignore
    }
  }
  return { columns, thinned: every > 1 };
}

type Curve = Pick<Series, 'name' | 'x' | 'y'>;

function linesOf(series: Series): Curve[] {
  const { name, x, y } = series;
  if (!series.error && !(series.low && series.high)) return [{ name, x, y }];
  const bars = Array.from({ length: x.length }, (_, i) => errorEnds(series, i));
  return [
    { name, x, y },
    { name: `${name}, from`, x, y: bars.map((bar) => bar?.[0] ?? null) },
    { name: `${name}, to`, x, y: bars.map((bar) => bar?.[1] ?? null) },
  ];
}

function edgesOf({ name, x, low, high }: Band): Curve[] {
  return [
    { name: `${name}, from`, x, y: low },
    { name: `${name}, to`, x, y: high },
  ];
}

function pairs(line: Curve): [number, number | null][] {
  return Array.from({ length: line.x.length }, (_, i): [number, number | null] => [
    line.x[i] ?? Number.NaN,
    line.y[i] ?? null,
  ]);
}

function places(lines: readonly { x: Numbers }[]): number[] {
  const all = new Set(lines.flatMap(({ x }) => Array.from(x).filter(finite)));
  return [...all].sort((a, b) => a - b);
}

/** A place where a curve has no point stays empty; a gap in it is a dash. */
function cell(value: number | null | undefined, axis: AxisScale): string {
  return value === undefined ? '' : axis.text(value);
}
