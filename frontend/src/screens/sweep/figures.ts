/** Figures that cases are compared by: a metric of a controller, of one axis or of the worse one. */

import { AXES, type SweepResult } from '../../app/api/types';
import { metricsOfAxis } from '../../parts/metrics/metric-rows';
import type { PlotAxis } from '../../plot/types';
import { clean, digits, prettyUnit, quantity } from '../../ui/units';

export type Numbers = readonly (number | null)[];
export const WORST = 'worst';
/** Of which axis: one of them, or the worse. */
export const PLACES = [...AXES, WORST] as const;
export type Place = (typeof PLACES)[number];

export interface Metric {
  key: string;
  name: string;
  unit: string;
  /** A margin of the loop: more of it is better, and it is shown in a unit of its own. */
  shown?: { unit: string; of: (value: number) => number; from: (shown: number) => number };
}

const MARGINS: readonly Metric[] = [
  {
    key: 'gain_margin',
    name: 'gain margin',
    unit: '1',
    shown: {
      unit: 'dB',
      of: (factor) => 20 * Math.log10(factor),
      from: (decibels) => 10 ** (decibels / 20),
    },
  },
  {
    key: 'phase_margin',
    name: 'phase margin',
    unit: 'rad',
    shown: {
      unit: '°',
      of: (angle) => (angle * 180) / Math.PI,
      from: (degrees) => (degrees * Math.PI) / 180,
    },
  },
];

/** Errors with a sign, of which neither less nor more is better. */
const SIGNED = new Set(['min_following_error', 'max_following_error', 'mean_following_error']);

export function metrics(): readonly Metric[] {
  return [...metricsOfAxis(), ...MARGINS];
}

export function metricOf(key: string): Metric {
  return metrics().find((each) => each.key === key) ?? { key, name: key, unit: '1' };
}

/** Takes a figure's name apart: `B.worst.gain_margin`. */
export function partsOf(name: string): { variant: string; place: Place; metric: Metric } {
  const [variant = '', place = WORST, key = ''] = name.split('.');
  return { variant, place: place as Place, metric: metricOf(key) };
}

/** A figure in words: "B x, max |e|". */
export function figureText(name: string): string {
  const { variant, place, metric } = partsOf(name);
  return `${variant} ${place}, ${metric.name}`;
}

/** All figures of some controllers, by controller; of objectives those that may be least. */
export function figureOptions(variants: readonly string[], objectives: boolean) {
  return variants.flatMap((variant) =>
    metrics()
      .filter(({ key }) => !objectives || !SIGNED.has(key))
      .flatMap(({ key, name }) =>
        [WORST, ...AXES].map((place) => ({
          value: `${variant}.${place}.${key}`,
          name: `${variant} ${place}, ${name}`,
          group: `controller ${variant}`,
        })),
      ),
  );
}

/** A figure in each case; empty where nothing has it. */
export function valuesOf(
  result: SweepResult,
  variant: string,
  place: Place,
  metric: string,
): Numbers {
  const of = result.variants[variant]?.axes ?? {};
  if (place !== WORST) return of[place]?.metrics[metric] ?? [];
  const columns = AXES.flatMap((axis) => {
    const column = of[axis]?.metrics[metric];
    return column ? [column] : [];
  });
  const worse = metricOf(metric).shown ? Math.min : Math.max;
  return (columns[0] ?? []).map((_, i) => {
    const values = columns.flatMap((column) => column[i] ?? []);
    return values.length > 0 ? worse(...values) : null;
  });
}

/** Values as they are drawn: margins in dB and degrees, others in SI. */
export function drawn(values: Numbers, { shown }: Metric): Numbers {
  return shown ? values.map((value) => (value === null ? null : shown.of(value))) : values;
}

/** An axis of values that `drawn` returns. */
export function axisOfMetric(metric: Metric, label: string): PlotAxis {
  const { shown, unit } = metric;
  return shown ? { label, scale: { factor: 1, unit: shown.unit } } : { label, unit };
}

export function valueOfMetric(value: number | null | undefined, { unit, shown }: Metric) {
  if (!shown || value === null || value === undefined) return quantity(value, unit);
  return { number: digits(shown.of(value)), unit: shown.unit };
}

/** Unit in which the bound of a figure is typed, and the way between it and SI. */
export function boundOf({ unit, shown }: Metric) {
  if (shown) return { unit: shown.unit, si: shown.from, of: shown.of };
  const factor = unit === 'm' ? 1e6 : 1;
  return {
    unit: unit === 'm' ? 'µm' : prettyUnit(unit),
    si: (typed: number) => clean(typed / factor),
    of: (value: number) => clean(value * factor),
  };
}
