/** Metrics of one variant now and in other runs, row by row. */

import type { Metrics, RunDetail, Scenario, Value, VariantMetrics } from '../../../app/api/types';
import { rows } from '../../../parts/metrics/metric-rows';
import { percent } from '../../../ui/units';
import { difference } from '../../../app/api/scenario-paths';
import { fieldOf, nameOf, show } from '../../../app/fields/fields.svelte';
import { KINDS } from '../../../parts/runs/run-text';

export interface ComparedRow {
  name: string;
  unit: string;
  meaning: string;
  main: boolean;
  now: string;
  then: { value: string; change: string }[];
}

/** Returns the rows of a variant; each run with its value and by how much the present one differs. */
export function comparedRows(
  now: Metrics,
  runs: readonly Metrics[],
  variant: string,
): ComparedRow[] {
  const columns = [now, ...runs].flatMap((metrics, i): [string, VariantMetrics][] => {
    const figures = metrics.variants[variant];
    return figures ? [[String(i), figures]] : [];
  });
  const all = { window: now.window, variants: Object.fromEntries(columns) };
  const order = [now, ...runs].map((_, i) => String(i));
  return rows(all, order).map(({ name, unit, meaning, main, values, numbers }) => ({
    name,
    unit,
    meaning,
    main,
    now: values[0] ?? '',
    then: values.slice(1).map((value, i) => ({
      value,
      change: percent((numbers[0] ?? Number.NaN) / (numbers[i + 1] ?? Number.NaN) - 1),
    })),
  }));
}

/** Whether two windows are alike as they are shown, to a hundredth of a second. */
export function sameWindow(a: Metrics['window'], b: Metrics['window']): boolean {
  return Math.abs(a.start - b.start) < 0.005 && Math.abs(a.end - b.end) < 0.005;
}

export interface Differing {
  name: string;
  /** `312 N/mm, now 200.3`. */
  text: string;
}

/** Returns the fields in which the run's scenario differs from the present one. */
export function differs(run: RunDetail, now: Scenario | null): Differing[] {
  const then = run.scenario_document;
  if (!then || !now) return [];
  return difference(then, now)
    .filter(({ path }) => path !== 'name')
    .map(({ path, from, to }) => {
      const of = (value: Value | undefined) =>
        value === undefined || value === null ? 'none' : show(path, value);
      const { unit } = fieldOf(path);
      return { name: nameOf(path), text: `${of(from)}${unit && ` ${unit}`}, now ${of(to)}` };
    });
}

/** What is said where no field differs. */
export function sameText(run: RunDetail): string {
  if (!run.scenario_document) return KINDS[run.kind];
  const changes = run.events.filter(({ kind }) => kind === 'change').length;
  const later =
    changes === 0 ? '' : `, changed ${changes === 1 ? 'once' : `${changes} times`} since 0 s`;
  return `as now${later}`;
}
