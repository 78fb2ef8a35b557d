/** What a sweep has found, as plots and tables show it: curves, a map, the best cases, a file. */

import type { SweepResult, Value } from '../../app/api/types';
import { nameOf, fieldOf } from '../../app/fields/fields.svelte';
import type { PlotAxis, Look, Series } from '../../plot/types';
import { csvRow } from '../../ui/export';
import { drawn, metricOf, valuesOf, type Numbers, type Place } from './figures';
import { valueText } from './sweep-form';

const LOOKS: readonly Look[] = [
  { ink: 'a', marker: 'square' },
  { ink: 'b', dash: 'dash', marker: 'circle' },
  { ink: 'phase-a', dash: 'dot', marker: 'triangle' },
  { ink: 'phase-b', dash: 'dashdot', marker: 'diamond' },
];
/** Values that differ by more than this are drawn on a logarithmic axis. */
const WIDE = 20;

/** Where a case is in the values of each swept field. */
export function placesOf({ fields, shape }: SweepResult, number: number): number[] {
  if (shape.length < fields.length) return fields.map(() => number);
  let rest = number;
  return fields.reduceRight<number[]>((places, { values }) => {
    places.unshift(rest % values.length);
    rest = Math.floor(rest / values.length);
    return places;
  }, []);
}

/** The values of the swept fields in one case. */
export function caseOf(result: SweepResult, number: number): Value[] {
  const places = placesOf(result, number);
  return result.fields.map(({ values }, k) => values[places[k] ?? 0] as Value);
}

/** The changes that make a case. */
export function changesOf(result: SweepResult, number: number): Record<string, Value> {
  const values = caseOf(result, number);
  return Object.fromEntries(result.fields.map(({ path }, k) => [path, values[k] as Value]));
}

/** A swept field as an axis: its numbers, or the place of each name in the list. */
export function axisOf(
  { path, values, unit }: SweepResult['fields'][number],
  log = false,
): { axis: PlotAxis; at: number[] } {
  if (!values.every((value) => typeof value === 'number')) {
    const names = values.map((value, i) => `${i + 1} ${valueText(path, value as Value)}`);
    const label = `${nameOf(path)}: ${names.join(', ')}`;
    return { axis: { label }, at: values.map((_, i) => i + 1) };
  }
  const at = values as number[];
  const { factor, unit: shown } = fieldOf(path);
  const scale = shown === '' ? {} : { scale: { factor, unit: shown } };
  return { axis: { label: nameOf(path), unit, log: log || wide(at), ...scale }, at };
}

/** Whether numbers are positive and far apart. */
export function wide(values: Numbers): boolean {
  const numbers = values.filter((value) => value !== null);
  return (
    numbers.length > 1 &&
    Math.min(...numbers) > 0 &&
    Math.max(...numbers) > WIDE * Math.min(...numbers)
  );
}

/** One curve for each variant over the first field, in its order on the axis. */
export function curvesOf(
  result: SweepResult,
  place: Place,
  metric: string,
  at: number[],
): Series[] {
  const order = at.map((_, i) => i).sort((a, b) => (at[a] ?? 0) - (at[b] ?? 0));
  return Object.keys(result.variants).flatMap((variant, k) => {
    const values = drawn(valuesOf(result, variant, place, metric), metricOf(metric));
    if (values.length === 0) return [];
    const look = LOOKS[k % LOOKS.length];
    return [
      {
        name: variant,
        x: order.map((i) => at[i] ?? 0),
        y: order.map((i) => values[i] ?? null),
        ...look,
      },
    ];
  });
}

/** A grid of two fields: columns and rows in ascending order, and the case of each cell. */
export function mapOf({ shape }: SweepResult, xs: readonly number[], ys: readonly number[]) {
  const sorted = (values: readonly number[]) =>
    values.map((value, i) => ({ value, i })).sort((a, b) => a.value - b.value);
  const [columns, rows] = [sorted(xs), sorted(ys)];
  return {
    xs: columns.map(({ value }) => value),
    ys: rows.map(({ value }) => value),
    cases: rows.map(({ i: j }) => columns.map(({ i }) => i * (shape[1] ?? 1) + j)),
  };
}

/** Whether every case has the same value: nothing that was swept matters to it. */
export function alike(values: Numbers): boolean {
  return values.every((value) => value === values[0]);
}

/** Cases that do not meet all limits. */
export function refusedOf({ limits }: Partial<Pick<SweepResult, 'limits'>>): ReadonlySet<number> {
  return new Set(limits?.flatMap(({ exceeded }) => exceeded));
}

/**
 * The case with the best value, of those that are not refused: the least, or of a margin the
 * largest; -1 where there is none.
 */
export function bestOf(
  values: Numbers,
  most = false,
  refused: ReadonlySet<number> = new Set(),
): number {
  const sign = most ? -1 : 1;
  return values.reduce<number>((best, value, i) => {
    const least = best < 0 ? Number.POSITIVE_INFINITY : sign * (values[best] ?? 0);
    return value !== null && !refused.has(i) && sign * value < least ? i : best;
  }, -1);
}

/** One row a case, in the columns of `motionlab sweep --out`: fields, then every metric. SI. */
export function csvOf(result: SweepResult): string {
  const columns = Object.entries(result.variants).flatMap(([name, { axes }]) =>
    Object.entries(axes).flatMap(([axis, { metrics }]) =>
      Object.entries(metrics).map(([metric, values]) => ({
        head: `${name}.${axis}.${metric}`,
        values,
      })),
    ),
  );
  const heads = [
    'case',
    ...result.fields.map(({ path }) => path),
    ...columns.map(({ head }) => head),
  ];
  const rows = Array.from({ length: result.cases }, (_, i) => [
    i,
    ...caseOf(result, i),
    ...columns.map(({ values }) => values[i] ?? ''),
  ]);
  return [heads, ...rows].map((row) => `${csvRow(row)}\n`).join('');
}
