/** The rows of the metrics table; names, units and definitions are the server's. */

import { among, pretty, scaleFor, type Scale } from '../../ui/units';
import type { Axis, AxisMetrics, MetricEntry, Metrics, VariantMetrics } from '../../app/api/types';
import { AXES } from '../../app/api/types';
import { served } from '../../app/fields/fields.svelte';

interface Shown<Key extends string = keyof AxisMetrics> {
  key: Key;
  /** Shown at once; the others on demand. */
  main?: boolean;
  /** Lines that share a unit, so that their numbers compare down the column too. */
  group?: 'following' | 'hold';
}

const FIRST: readonly Shown[] = [
  { key: 'max_abs_following_error', main: true, group: 'following' },
  { key: 'rms_following_error', main: true, group: 'following' },
];
const CONTOUR: readonly Shown<'max' | 'rms'>[] = [
  { key: 'max', main: true, group: 'following' },
  { key: 'rms', group: 'following' },
];
const OTHERS: readonly Shown[] = [
  { key: 'itae' },
  { key: 'steady_state_error', main: true, group: 'hold' },
  { key: 'settling_time', main: true },
  { key: 'overshoot', group: 'hold' },
  { key: 'max_abs_velocity' },
  { key: 'rms_force' },
  { key: 'max_abs_force' },
  { key: 'max_current', main: true },
  { key: 'rms_current' },
  { key: 'saturated_fraction' },
];

export interface MetricRow {
  name: string;
  unit: string;
  meaning: string;
  main: boolean;
  values: string[];
  numbers: readonly number[];
  /** Second variant against the first, a share; null where there is no such figure. */
  change: number | null;
}

interface Line {
  shown: Shown<string>;
  definition: MetricEntry;
  axis: Axis | '';
  numbers: number[];
}

/** Returns the rows for some variants; those without any number are left out. */
export function rows(metrics: Metrics, variants: readonly string[]): MetricRow[] {
  const of = variants.map((name) => metrics.variants[name]);
  const lines: Line[] = [];
  const add = (
    shown: Shown<string>,
    definition: MetricEntry | undefined,
    axis: Axis | '',
    values: (number | null | undefined)[],
  ) => {
    const numbers = values.map((value) => value ?? Number.NaN);
    if (!definition || numbers.every(Number.isNaN)) return;
    lines.push({ shown, definition, axis, numbers });
  };
  const addAxes = (shown: Shown) => {
    const definition = served.scenario.metrics[shown.key];
    for (const axis of AXES) add(shown, definition, axis, axisValues(of, axis, shown.key));
  };
  FIRST.forEach(addAxes);
  for (const shown of CONTOUR) {
    const values = of.map((variant) => variant?.contour?.[shown.key]);
    add(shown, served.scenario.contour[shown.key], '', values);
  }
  OTHERS.forEach(addAxes);
  return lines.map((line) => row(line, scaleOf(line, lines)));
}

/** Says which changes lie within the window, as its numbers are of both before and after. */
export function changesWithin({ start, end }: Metrics['window'], times: readonly number[]): string {
  const within = [...new Set(times.filter((time) => time > start && time < end))]
    .sort((a, b) => a - b)
    .map((time) => Number(time.toFixed(2)));
  const last = within.pop();
  if (last === undefined) return '';
  if (within.length === 0) return `Includes a change at ${last} s.`;
  if (within.length > 2) return `Includes ${within.length + 1} changes, the last at ${last} s.`;
  return `Includes changes at ${within.join(', ')} and ${last} s.`;
}

function axisValues(
  shown: readonly (VariantMetrics | undefined)[],
  axis: Axis,
  key: keyof AxisMetrics,
) {
  return shown.map((variant) => variant?.axes[axis]?.[key]);
}

/** The unit of a line: that of all lines of its group, or of both axes. */
function scaleOf({ shown, definition }: Line, lines: readonly Line[]): Scale {
  const alike = lines.filter(({ shown: other }) =>
    shown.group ? other.group === shown.group : other === shown,
  );
  const sizes = alike.flatMap(({ numbers }) => numbers.filter(Number.isFinite).map(Math.abs));
  return scaleFor(Math.max(...sizes), definition.unit);
}

function row({ shown, definition, axis, numbers }: Line, scale: Scale): MetricRow {
  const [a = Number.NaN, b = Number.NaN] = numbers;
  const change = a !== 0 && Number.isFinite(b / a) ? b / a - 1 : null;
  return {
    name: definition.label.replace('$', axis),
    unit: scale.unit,
    meaning: pretty(definition.meaning),
    main: shown.main === true,
    values: numbers.map((value) => among(value, scale)),
    numbers,
    change,
  };
}

/** Metrics of an axis that can be compared over many runs: key, name without its axis, unit. */
export function metricsOfAxis(): readonly { key: string; name: string; unit: string }[] {
  return Object.entries(served.scenario.metrics).map(([key, { label, unit }]) => ({
    key,
    name: label.replace(/ ?_?\$/, '').trim(),
    unit,
  }));
}
