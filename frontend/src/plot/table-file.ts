/** Numbers of plots and tables as CSV and as text for a spreadsheet. */

import { cellText, csvRow } from '../ui/export';
import { ascending, errorEnds, finite } from './curves';
import type { CurveData, GridData, PlotData, SourceData } from './plot-menu';
import type { Column } from './table-columns';
import type { Numbers } from './types';

/** Rows of a file: more samples are summed up by their least and largest. */
const ROWS = 200_000;

/** A row of names with units, then rows of numbers in SI. */
export type Table = readonly (readonly (string | number | null)[])[];

/** Writes a table as CSV: a point for the decimal sign, a comma between, lines end in \r\n. */
export function csvOf(table: Table): string {
  return table.map((row) => `${csvRow(row.map(plain))}\r\n`).join('');
}

/** Writes a table as a spreadsheet takes it from the clipboard. */
export function tabbed(table: Table): string {
  return table.map((row) => row.map((cell) => cellText(plain(cell))).join('\t')).join('\n');
}

/** Returns the numbers of a plot. */
export function tableOf(data: PlotData): Table {
  if ('source' in data) return ofSource(data);
  return 'rows' in data ? ofGrid(data) : ofCurves(data);
}

/** Returns a table of the page: as it is shown, with signs that a program reads. */
export function shownTable(columns: readonly Column[]): Table {
  const length = columns[0]?.cells.length ?? 0;
  return [
    columns.map(({ name, unit }) => named(name, unit)),
    ...Array.from({ length }, (_, i) => columns.map(({ cells }) => cells[i] ?? '')),
  ];
}

function ofSource({ source, range, traces }: SourceData): Table {
  if (!source) return [];
  const there = traces.filter(({ column }) => source.has(column));
  const bins = source.cut(range.from, range.to, ROWS);
  const ends = there.map(({ column }) => {
    const [low, high] = [new Float32Array(bins.count), new Float32Array(bins.count)];
    source.reduce(column, bins, low, high);
    return { low, high, same: low.every((value, i) => Object.is(value, high[i])) };
  });
  const head = there.flatMap(({ label, unit }, i) =>
    ends[i]?.same
      ? [named(label, unit)]
      : [named(`${label} least`, unit), named(`${label} largest`, unit)],
  );
  const rows = Array.from({ length: bins.count }, (_, k) => [
    tidy(source.start + (bins.first + k * bins.size) * source.step),
    ...ends.flatMap(({ low, high, same }) => (same ? [low[k]] : [low[k], high[k]]).map(single)),
  ]);
  return [[named('time', 's'), ...head], ...rows];
}

function ofCurves({ series, bands, x, y }: CurveData): Table {
  const units = [x.axis.unit, y.axis.unit] as const;
  const lines = [
    ...series.flatMap((one) => {
      const line = { name: one.name, x: one.x, y: one.y };
      if (!one.error && !(one.low && one.high)) return [line];
      const bars = Array.from({ length: one.x.length }, (_, i) => errorEnds(one, i));
      const end = (k: 0 | 1) => bars.map((bar) => bar?.[k] ?? null);
      return [
        line,
        { name: `${one.name}, from`, x: one.x, y: end(0) },
        { name: `${one.name}, to`, x: one.x, y: end(1) },
      ];
    }),
    ...bands.flatMap(({ name, x, low, high }) => [
      { name: `${name}, from`, x, y: low },
      { name: `${name}, to`, x, y: high },
    ]),
  ];
  if (lines.every((line) => ascending(line.x))) {
    const places = [...new Set(lines.flatMap((line) => Array.from(line.x).filter(finite)))];
    places.sort((a, b) => a - b);
    const values = lines.map(
      (line) => new Map(Array.from(line.x, (at, i) => [at, line.y[i] ?? null])),
    );
    return [
      [named(x.label, units[0]), ...lines.map(({ name }) => named(name, units[1]))],
      ...places.map((at) => [at, ...values.map((each) => each.get(at) ?? null)]),
    ];
  }
  const length = Math.max(0, ...lines.map((line) => line.x.length));
  const at = (numbers: Numbers, i: number) => numbers[i] ?? null;
  return [
    lines.flatMap(({ name }) => [named(`${name}: ${x.label}`, units[0]), named(name, units[1])]),
    ...Array.from({ length }, (_, i) => lines.flatMap((line) => [at(line.x, i), at(line.y, i)])),
  ];
}

function ofGrid({ xs, ys, rows, x, y, z, layers = [] }: GridData): Table {
  return [
    [
      ...[x, y, z].map(({ label, axis }) => named(label, axis.unit)),
      ...layers.map(({ label, unit }) => named(label, unit)),
    ],
    ...Array.from(ys, (down, j) =>
      Array.from(xs, (across, i) => [
        across,
        down,
        ...[rows, ...layers.map((layer) => layer.rows)].map((of) => of[j]?.[i] ?? null),
      ]),
    ).flat(),
  ];
}

function named(name: string, unit = '1'): string {
  return unit === '' || unit === '1' ? name : `${name} [${unit}]`;
}

/** Without the tail that binary fractions have. */
function tidy(value: number): number {
  return Number(value.toPrecision(12));
}

/** A number of single precision in as few digits as tell it from all others. */
function single(value: number | undefined): number | null {
  if (value === undefined || !Number.isFinite(value)) return null;
  for (let digits = 6; digits < 9; digits++) {
    const short = Number(value.toPrecision(digits));
    if (Math.fround(short) === value) return short;
  }
  return Number(value.toPrecision(9));
}

/** As it is shown, with signs that a program reads. */
function plain(cell: string | number | null): string | number | null {
  return typeof cell === 'string' ? cell.replaceAll('\u2212', '-').replace(/^\u2013$/, '') : cell;
}
