/** Results of a Monte Carlo study for display: bands, quantiles, probability of meeting a spec. */

import type { Axis, MonteCarlo } from '../../../app/api/types';
import { AXES } from '../../../app/api/types';
import type { QuantileBand } from '../../../plot/quantile-band';
import { among, digits, scaleFor } from '../../../ui/units';

export type Spec = Partial<Record<Axis, number>>;

export interface Share {
  share: number;
  low: number;
  high: number;
}

const LOOKS: readonly Pick<QuantileBand, 'ink' | 'dash'>[] = [
  { ink: 'a', dash: 'solid' },
  { ink: 'b', dash: 'dot' },
];
const Z = 1.959964;

/** Share of the plants that stay within a spec on every axis it names, with Wilson's 95 % interval. */
export function meeting(study: MonteCarlo, variant: string, spec: Spec): Share | null {
  const axes = study.variants[variant]?.axes ?? {};
  const limits = AXES.flatMap((axis) => {
    const [limit, peaks] = [spec[axis], axes[axis]?.peaks];
    return limit === undefined || !peaks ? [] : [{ limit, peaks }];
  });
  if (limits.length === 0) return null;
  const n = study.cases;
  let hits = 0;
  for (let k = 0; k < n; k++) {
    const within = ({ limit, peaks }: { limit: number; peaks: (number | null)[] }) => {
      const peak = peaks[k] ?? null;
      return peak !== null && peak <= limit;
    };
    if (limits.every(within)) hits += 1;
  }
  const p = hits / n;
  const scale = 1 + Z ** 2 / n;
  const middle = (p + Z ** 2 / (2 * n)) / scale;
  const half = (Z * Math.sqrt((p * (1 - p)) / n + Z ** 2 / (4 * n ** 2))) / scale;
  return {
    share: p,
    low: hits === 0 ? 0 : middle - half,
    high: hits === n ? 1 : middle + half,
  };
}

/** Returns the bands of one axis of the first two variants. */
export function quantileBands(study: MonteCarlo, axis: Axis): QuantileBand[] {
  return Object.entries(study.variants)
    .slice(0, 2)
    .flatMap(([variant, { axes }], i) => {
      const band = axes[axis]?.band;
      const look = LOOKS[i];
      if (!band || !look) return [];
      const { min, q05, q95, max } = band;
      const column = `${variant}.${axis}.following_error`;
      return [{ ...look, column, time: study.time, least: min, low: q05, high: q95, most: max }];
    });
}

export interface SpreadRow {
  name: string;
  unit: string;
  values: string[];
}

/** The quantiles of the largest and RMS following error, one unit for a metric of an axis, and how much the second variant gains. */
export function spreadRows(study: MonteCarlo): SpreadRow[] {
  const rows: SpreadRow[] = [];
  for (const axis of AXES) {
    for (const [key, title] of [
      ['max_abs_following_error', `max |e_${axis}|`],
      ['rms_following_error', `RMS e_${axis}`],
    ] as const) {
      const spreads = Object.entries(study.variants).flatMap(([variant, { axes }]) => {
        const spread = axes[axis]?.metrics[key];
        return spread ? [{ variant, spread }] : [];
      });
      const scale = scaleFor(Math.max(...spreads.map(({ spread }) => spread.q50)), 'm');
      for (const { variant, spread } of spreads) {
        const values = [spread.q05, spread.q50, spread.q95].map((v) => among(v, scale));
        rows.push({ name: `${variant} ${title}`, unit: scale.unit, values });
      }
    }
    const gain = study.improvement[axis]?.max_abs_following_error;
    if (!gain) continue;
    const values = [gain.q05, gain.q50, gain.q95].map((v) => digits(100 * v, 2));
    rows.push({ name: `less max |e_${axis}| in B`, unit: '%', values });
  }
  return rows;
}

/** The worst plant of each variant and axis. */
export function worstOfEach({ worst }: MonteCarlo): MonteCarlo['worst'] {
  return worst.filter(
    ({ variant, axis }, i) =>
      worst.findIndex((one) => one.variant === variant && one.axis === axis) === i,
  );
}

/** 0.717 as "71.7 %"; never rounded to all or nothing where it is neither. */
export function shareText(share: number): string {
  if (share > 0 && share < 0.001) return '< 0.1 %';
  if (share < 1 && share > 0.999) return '> 99.9 %';
  return `${(100 * share).toFixed(share === 0 || share === 1 ? 0 : 1)} %`;
}

/** Whether bands and curves cover the same stretch of time, to a bin. */
export function covers(time: readonly number[], start: number, end: number): boolean {
  const [first, last] = [time[0], time.at(-1)];
  if (first === undefined || last === undefined) return false;
  const slack = (end - start) / 100;
  return Math.abs(first - start) < slack && Math.abs(last - end) < slack;
}
