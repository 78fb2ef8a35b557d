/** What the cases of a sweep are compared by: its objectives, or the metric that is looked at. */

import type { SweepResult } from '../../app/api/types';
import {
  figureText,
  metricOf,
  partsOf,
  valuesOf,
  type Metric,
  type Numbers,
  type Place,
} from './figures';

export interface Compared {
  name: string;
  metric: Metric;
  values: Numbers;
}

/** The objectives of a result; without any a metric of every controller. */
export function comparedOf(result: SweepResult, place: Place, key: string): Compared[] {
  if (result.objectives.length > 0) {
    return result.objectives.map(({ of, values }) => ({
      name: figureText(of),
      metric: partsOf(of).metric,
      values,
    }));
  }
  return Object.keys(result.variants).flatMap((variant) => {
    const one = oneOf(result, variant, place, key);
    return one.values.length > 0 ? [one] : [];
  });
}

/** One metric of one controller. */
export function oneOf(result: SweepResult, variant: string, place: Place, key: string): Compared {
  const metric = metricOf(key);
  const values = valuesOf(result, variant, place, key);
  return { name: `${variant} ${place}, ${metric.name}`, metric, values };
}

/** The case whose point is nearest to a place of a picture, by shares of its width and height. */
export function nearestCase(xs: Numbers, ys: Numbers, x: number, y: number | null): number {
  const span = (of: Numbers) => {
    const known = of.filter((value) => value !== null);
    return Math.max(...known) - Math.min(...known) || 1;
  };
  const [width, height] = [span(xs), span(ys)];
  let [least, index] = [Number.POSITIVE_INFINITY, -1];
  xs.forEach((value, i) => {
    const across = ys[i] ?? null;
    if (value === null || across === null) return;
    const off = ((value - x) / width) ** 2 + ((across - (y ?? across)) / height) ** 2;
    if (off < least) [least, index] = [off, i];
  });
  return index;
}
