/** Lines over parallel axes: where they are, which of them pass what is kept, which one is near. */

import { AxisScale, ends, extent } from './axis-scale';
import { finite } from './curves';
import type { Numbers, PlotAxis } from './types';

export interface ParallelAxis {
  axis: PlotAxis;
  /** One number a line. */
  values: Numbers;
}

/** What is kept of an axis, in its values. */
export type Kept = Readonly<Record<number, readonly [number, number]>>;

export interface ParallelLayout {
  scales: readonly AxisScale[];
  xs: readonly number[];
  top: number;
  bottom: number;
}

const TOP = 44;
const BOTTOM = 12;
const SIDE = 46;

export function parallelLayout(
  axes: readonly ParallelAxis[],
  width: number,
  height: number,
): ParallelLayout {
  const bottom = Math.max(TOP + 20, height - BOTTOM);
  const scales = axes.map(({ axis, values }) => {
    const span = extent(Array.from(values), axis.log);
    return new AxisScale(axis, ...ends(axis, span, true), [bottom, TOP]);
  });
  const apart = (width - 2 * SIDE) / Math.max(1, axes.length - 1);
  return { scales, xs: axes.map((_, k) => SIDE + k * apart), top: TOP, bottom };
}

/** Whether each line passes everything that is kept. */
export function passing(axes: readonly ParallelAxis[], kept: Kept): boolean[] {
  const filters = Object.entries(kept).map(([k, [low, high]]) => {
    const values = axes[Number(k)]?.values ?? [];
    return (i: number) => {
      const value = values[i];
      return finite(value) && value >= low && value <= high;
    };
  });
  const count = axes[0]?.values.length ?? 0;
  return Array.from({ length: count }, (_, i) => filters.every((filter) => filter(i)));
}

/** Height of a line above an axis; NaN where it has no value there. */
export function heightOf({ scales }: ParallelLayout, axes: readonly ParallelAxis[], k: number) {
  const [scale, values] = [scales[k], axes[k]?.values];
  return (i: number) => (scale && values ? scale.px(values[i]) : Number.NaN);
}

/** The line that passes nearest to a point, of those that pass; -1 without one within reach. */
export function nearestLine(
  layout: ParallelLayout,
  axes: readonly ParallelAxis[],
  passes: readonly boolean[],
  px: number,
  py: number,
  reach = 24,
): number {
  const { xs } = layout;
  const k = Math.max(0, Math.min(xs.length - 2, xs.findIndex((x) => x > px) - 1));
  const [from, to] = [xs[k] ?? 0, xs[k + 1] ?? 1];
  const share = Math.min(1, Math.max(0, (px - from) / (to - from || 1)));
  const [left, right] = [heightOf(layout, axes, k), heightOf(layout, axes, k + 1)];
  let [best, index] = [reach, -1];
  for (let i = 0; i < passes.length; i++) {
    if (!passes[i]) continue;
    const at = left(i) * (1 - share) + (xs.length > 1 ? right(i) * share : 0);
    const distance = Math.abs(at - py);
    if (distance < best) [best, index] = [distance, i];
  }
  return index;
}

/** The axis whose line is near a pixel; -1 without one. */
export function axisAt({ xs }: ParallelLayout, px: number, reach = 14): number {
  return xs.findIndex((x) => Math.abs(x - px) <= reach);
}

/** The next line along an axis, by its value, among those that pass. */
export function nextAlong(
  values: Numbers,
  passes: readonly boolean[],
  from: number | null,
  by: number,
): number | null {
  const order = Array.from(values, (_, i) => i)
    .filter((i) => passes[i] && finite(values[i]))
    .sort((a, b) => (values[a] as number) - (values[b] as number) || a - b);
  if (order.length === 0) return null;
  const at = from === null ? -1 : order.indexOf(from);
  const next = at < 0 ? (by > 0 ? 0 : order.length - 1) : at + by;
  return order[Math.min(order.length - 1, Math.max(0, next))] ?? null;
}
