/** A metric over the plants: its histogram for a plot, and which drawn parameter decides. */

import type { Axis, MonteCarlo } from '../../../app/api/types';
import { fieldOf } from '../../../app/fields/fields.svelte';
import { metricsOfAxis } from '../../../parts/metrics/metric-rows';
import type { Series } from '../../../plot/types';

export interface ShownMetric {
  key: string;
  name: string;
  unit: string;
}

/** The metrics of an axis that differ from plant to plant, the largest error first. */
export function metricsShown(study: MonteCarlo, axis: Axis): ShownMetric[] {
  return metricsOfAxis().filter(({ key }) => study.histograms?.[axis]?.[key]);
}

/** The axes that move. */
export function axesShown(study: MonteCarlo): Axis[] {
  return (['x', 'y'] as const).filter((axis) => study.histograms?.[axis]);
}

const LOOKS: readonly Pick<Series, 'ink' | 'dash' | 'area'>[] = [
  { ink: 'a', dash: 'solid', area: 'tinted' },
  { ink: 'b', dash: 'dash', area: 'hatched' },
];

/** Plants in each bin, of the first two variants: steps from edge to edge. */
export function histogramSeries(study: MonteCarlo, axis: Axis, metric: string): Series[] {
  const histogram = study.histograms?.[axis]?.[metric];
  if (!histogram) return [];
  return Object.entries(histogram.counts)
    .slice(0, 2)
    .map(([name, counts], i) => ({
      name,
      kind: 'step' as const,
      x: histogram.edges,
      y: [...counts, null],
      ...LOOKS[i],
    }));
}

export interface Influence {
  key: string;
  /** `F_s`, `deviation of F_s`, `amplifier offset, phase 2`. */
  name: string;
  /** Of each variant; null where there is none. */
  rho: readonly (number | null)[];
  /** Whether any of them is beyond chance. */
  beyond: boolean;
}

const size = (value: number | null | undefined) => Math.abs(value ?? 0);

/**
 * Rank correlations of a metric with the drawn parameters, the strongest first; of value and
 * deviation of a parameter the one that is weaker for every variant is left out.
 */
export function influences(study: MonteCarlo, axis: Axis, metric: string): Influence[] {
  const parameters = study.parameters?.[axis] ?? [];
  const columns = Object.values(study.variants)
    .slice(0, 2)
    .map(({ axes }) => axes[axis]?.correlations?.[metric] ?? []);
  const rows = parameters.map(({ path, of }, k) => {
    const rho = columns.map((column) => column[k] ?? null);
    return { path, of, rho, key: `${of} ${path}`, most: Math.max(...rho.map(size)) };
  });
  const weaker = ({ path, of, rho }: (typeof rows)[number]) => {
    const twin = rows.find((other) => other.path === path && other.of !== of);
    if (!twin) return false;
    const less = rho.every((value, i) => size(value) <= size(twin.rho[i]));
    const same = rho.every((value, i) => size(value) === size(twin.rho[i]));
    return less && (!same || of === 'deviation');
  };
  return rows
    .filter((row) => row.most > 0 && !weaker(row))
    .sort((one, other) => other.most - one.most)
    .map(({ path, of, rho, key, most }) => ({
      key,
      name: `${of === 'deviation' ? 'deviation of ' : ''}${parameterName(path, axis)}`,
      rho,
      beyond: most > (study.significant ?? 1),
    }));
}

/** A number of the plant without its axis, which is chosen above; of a list also its phase. */
function parameterName(path: string, axis: Axis): string {
  const [, whole = path, item] = /^(.*?)(?:\.(\d+))?$/.exec(path) ?? [];
  const label = fieldOf(`plant.${axis}.${whole}`).label.replace(new RegExp(` ${axis}$`), '');
  return item === undefined ? label : `${label}, phase ${'abc'.charAt(Number(item))}`;
}
