/** The rows of the metrics table; names, units, order and definitions are the server's. */

import { among, pretty, scaleFor, type Scale } from '../../ui/units';
import type {
  Axis,
  AxisMetrics,
  ContourMetrics,
  MetricEntry,
  Metrics,
  VariantMetrics,
} from '../../app/api/types';
import { AXES } from '../../app/api/types';
import { served } from '../../app/fields/fields.svelte';

export interface MetricRow {
  name: string;
  unit: string;
  meaning: string;
  main: boolean;
  /** Of which axis; empty of what is of both. */
  axis: Axis | '';
  /** Whether it is of the following error, of which one can ask why. */
  following: boolean;
  values: string[];
  numbers: readonly number[];
  /** Second variant against the first, a share; null where there is no such figure. */
  change: number | null;
}

interface Line {
  key: string;
  definition: MetricEntry;
  axis: Axis | '';
  numbers: number[];
}

/** Returns the rows for some variants; those without any number are left out. */
export function rows(metrics: Metrics, variants: readonly string[]): MetricRow[] {
  const of = variants.map((name) => metrics.variants[name]);
  const { metrics: axisMetrics, contour } = served.scenario;
  const lines: Line[] = [];
  const add = (
    key: string,
    definition: MetricEntry,
    axis: Axis | '',
    values: (number | null | undefined)[],
  ) => {
    const numbers = values.map((value) => value ?? Number.NaN);
    if (definition.rank === 'hidden' || numbers.every(Number.isNaN)) return;
    lines.push({ key, definition, axis, numbers });
  };
  const addAxes = (key: string, definition: MetricEntry) => {
    for (const axis of AXES) add(key, definition, axis, axisValues(of, axis, key));
  };
  const [following, others] = partition(Object.entries(axisMetrics), isFollowing);
  // The distance from the path stands below the errors that it is compared with.
  following.forEach((entry) => addAxes(...entry));
  for (const [key, definition] of Object.entries(contour)) {
    const values = of.map((variant) => variant?.contour?.[key as keyof ContourMetrics]);
    add(key, definition, '', values);
  }
  others.forEach((entry) => addAxes(...entry));
  return lines.map((line) => row(line, scaleOf(line, lines)));
}

const isFollowing = ([, { scale }]: [string, MetricEntry]) => scale === 'following';

function partition<T>(items: readonly T[], test: (item: T) => boolean): [T[], T[]] {
  return [items.filter(test), items.filter((item) => !test(item))];
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

function axisValues(shown: readonly (VariantMetrics | undefined)[], axis: Axis, key: string) {
  return shown.map((variant) => variant?.axes[axis]?.[key as keyof AxisMetrics]);
}

/** The unit of a line: that of all lines of its scale, or of both axes. */
function scaleOf({ key, definition: { scale, unit } }: Line, lines: readonly Line[]): Scale {
  const alike = lines.filter(({ key: other, definition }) =>
    scale ? definition.scale === scale : other === key,
  );
  const sizes = alike.flatMap(({ numbers }) => numbers.filter(Number.isFinite).map(Math.abs));
  return scaleFor(Math.max(...sizes), unit);
}

function row({ definition, axis, numbers }: Line, scale: Scale): MetricRow {
  const [a = Number.NaN, b = Number.NaN] = numbers;
  const change = a !== 0 && Number.isFinite(b / a) ? b / a - 1 : null;
  return {
    name: definition.label.replace('$', axis),
    unit: scale.unit,
    meaning: pretty(definition.meaning),
    main: definition.rank === 'main',
    axis,
    following: definition.scale === 'following',
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
