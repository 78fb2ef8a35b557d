/** Columns of the list of runs: a metric or a field of the scenario, of A above B. */

import { AXES, type Run, type Scenario, type Value } from '../../app/api/types';
import { at } from '../../app/api/scenario-paths';
import { fieldOf, type Entries } from '../../app/fields/fields.svelte';
import type { FinderOption } from '../../ui/finder';
import { among, decibels, degrees, digits, quantity } from '../../ui/units';

/** Columns at once: more have no room beside names. */
export const MOST = 3;

export interface Metric {
  /** Short name of the search language, such as `x.max`. */
  id: string;
  /** Name in the metrics of a run, after the variant. */
  metric: string;
  label: string;
  unit: string;
  /** The number in that unit of a value in SI. */
  shown: (value: number) => number;
}

const micro = (value: number) => value * 1e6;

const METRICS = [
  ['max', 'max_abs_following_error', 'max e', 'µm', micro],
  ['rms', 'rms_following_error', 'RMS e', 'µm', micro],
  ['force', 'max_abs_force', 'peak F', 'N', (value: number) => value],
  ['settling', 'settling_time', 'settling', 'ms', (value: number) => value * 1e3],
  ['steady', 'steady_state_error', 'steady e', 'µm', micro],
  ['gain_margin', 'gain_margin', 'GM', 'dB', decibels],
  ['phase_margin', 'phase_margin', 'PM', '°', degrees],
] as const;

export const METRIC_COLUMNS: readonly Metric[] = METRICS.flatMap(
  ([name, metric, label, unit, shown]) =>
    (['x', 'y'] as const).map((axis) => ({
      id: `${axis}.${name}`,
      metric: `${axis}.${metric}`,
      label: `${label}_${axis}`.replace(/^settling_/, 'settling '),
      unit,
      shown,
    })),
);

export const USUAL = ['x.max', 'y.max'] as const;

export interface Column {
  id: string;
  label: string;
  unit: string;
  /** Null of a field. */
  metric: Metric | null;
}

/** Returns the column of a metric or of a field, `variants.*.controller.x.k_p`; null of neither. */
export function columnOf(id: string, entries?: Entries): Column | null {
  const metric = METRIC_COLUMNS.find((each) => each.id === id);
  if (metric) return { id, label: metric.label, unit: metric.unit, metric };
  if (entries && !(id in entries)) return null;
  const { label, unit } = fieldOf(id, entries);
  const owner = /^plant\.([xy])\./.exec(id)?.[1];
  return { id, label: owner ? `${label} ${owner}` : label, unit, metric: null };
}

/** Returns what can be a column: metrics, then every number and choice of a scenario. */
export function columnChoices(entries: Entries): FinderOption<string>[] {
  const metrics = METRIC_COLUMNS.map(({ id, metric, label, unit }) => ({
    value: id,
    name: label,
    detail: `${metric.slice(2).replaceAll('_', ' ')}, ${unit}`,
  }));
  const fields = Object.keys(entries)
    .filter(
      (path) => !/^(name|title|description|schedule|variants)$|\.parts\.|description$/.test(path),
    )
    .flatMap((path) => columnOf(path, entries) ?? [])
    .map(({ id, label, unit }) => ({ value: id, name: label, detail: `${id} ${unit}`.trim() }));
  return [...metrics, ...fields];
}

/** Returns the number of a column that a variant of a run has; null without one. */
export function figureOf(
  column: Column,
  run: Run,
  variant: string,
  shipped: Scenario | null,
): number | string | null {
  if (column.metric) return run.metrics[`${variant}.${column.metric.metric}`] ?? null;
  const path = column.id.replace('variants.*', `variants.${variant}`);
  const set = run.differences.find((each) => each.path === path);
  const value = set ? (set.value as Value) : at(shipped, path);
  return typeof value === 'number' || typeof value === 'string'
    ? value
    : typeof value === 'boolean'
      ? value
        ? 'on'
        : 'off'
      : null;
}

/** Returns the largest glitch of a variant of a capture, `glitch x 36.5 µm`; empty without one. */
export function glitchText({ capture }: Run, variant: string): string {
  const [largest] = AXES.flatMap((axis) => {
    const height = capture?.glitches[`${variant}.${axis}.following_error`];
    return height === undefined ? [] : [{ axis, height: Math.abs(height) }];
  }).sort((a, b) => b.height - a.height);
  if (!largest) return '';
  const { number, unit } = quantity(largest.height, 'm');
  return `glitch ${largest.axis} ${number} ${unit}`;
}

/** Writes a figure in the unit of its column. */
export function figureText(column: Column, value: number | string | null): string {
  if (value === null) return '–';
  if (typeof value === 'string') return value;
  if (column.metric) return among(column.metric.shown(value), { factor: 1, unit: column.unit });
  const { factor, whole } = fieldOf(column.id);
  return whole ? String(value) : digits(value * factor, 4).replace(/\.?0+$/, '');
}
