/** Properties of a plot's series: extents, error bars, and the points nearest to a cursor. */

import { extent, type AxisScale, type Extent } from './axis-scale';
import { edges } from './heat-grid';
import type { PlotAxis, Band, Cursor, Mark, Numbers, Series } from './types';

function* each(numbers: Numbers): Generator<number | null> {
  for (let i = 0; i < numbers.length; i++) yield numbers[i] ?? null;
}

/** Extent of all that is drawn, along one axis. */
export function extentOf(
  way: 'x' | 'y',
  axis: PlotAxis,
  series: readonly Series[],
  bands: readonly Band[],
  marks: readonly Mark[] = [],
): Extent | null {
  function* all(): Generator<number | null> {
    for (const one of series) {
      yield* each(one[way]);
      if (way === 'x') {
        if (one.kind === 'bars') yield* edges(Array.from(one.x).filter(finite), axis.log);
        continue;
      }
      if (one.kind === 'bars' && axis.log !== true) yield 0;
      for (let i = 0; i < one.y.length; i++) yield* errorEnds(one, i) ?? [];
    }
    for (const band of bands) {
      if (way === 'x') yield* each(band.x);
      else {
        yield* each(band.low);
        yield* each(band.high);
      }
    }
    for (const mark of marks) if (mark.axis === way) yield mark.at;
  }
  return extent(all(), axis.log);
}

/** The two ends of an error bar, or null where there is none. */
export function errorEnds(series: Series, i: number): [number, number] | null {
  const value = series.y[i];
  const half = series.error?.[i];
  if (finite(value) && finite(half)) return [value - half, value + half];
  const [low, high] = [series.low?.[i], series.high?.[i]];
  return finite(low) && finite(high) ? [low, high] : null;
}

export function finite(value: number | null | undefined): value is number {
  return value !== null && value !== undefined && Number.isFinite(value);
}

export function ascending(numbers: Numbers): boolean {
  let before = Number.NEGATIVE_INFINITY;
  for (const value of each(numbers)) {
    if (!finite(value)) continue;
    if (value < before) return false;
    before = value;
  }
  return true;
}

/**
 * Index of the point nearest to a cursor, -1 where there is none: along x for a curve over x, in
 * the picture for a loop.
 */
export function nearest(line: Pick<Series, 'x' | 'y'>, at: Cursor, x: AxisScale, y: AxisScale) {
  const flat = at.y === null || ascending(line.x);
  const [px, py] = [x.px(at.x), y.px(at.y)];
  let [best, index] = [Number.POSITIVE_INFINITY, -1];
  for (let i = 0; i < line.x.length; i++) {
    const along = x.px(line.x[i]) - px;
    const across = flat ? (finite(line.y[i]) ? 0 : Number.NaN) : y.px(line.y[i]) - py;
    const distance = along * along + across * across;
    if (distance < best) [best, index] = [distance, i];
  }
  return index;
}

/** The finest curve: keys that follow it jump over no point. */
export function leading(series: readonly Series[]): Series | null {
  return series.reduce<Series | null>(
    (best, one) => (best && best.x.length >= one.x.length ? best : one),
    null,
  );
}

/** The next point of a series for a cursor that keys move. */
export function stepped(
  series: Series | null,
  at: Cursor | null,
  by: number,
  x: AxisScale,
  y: AxisScale,
): Cursor | null {
  if (!series || series.x.length === 0) return null;
  const last = series.x.length - 1;
  const now = at ? nearest(series, at, x, y) : -1;
  const from = now >= 0 ? now : by > 0 ? -1 : last + 1;
  let i = Math.min(last, Math.max(0, from + by));
  // Over a gap, to the next point beyond it.
  while (i >= 0 && i <= last && !(finite(series.x[i]) && finite(series.y[i]))) i += Math.sign(by);
  const [px, py] = [series.x[i], series.y[i]];
  return finite(px) && finite(py) ? { x: px, y: py } : at;
}
