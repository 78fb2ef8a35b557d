/** What Plot draws of its series: paths, error bars, markers, and the points nearest to a cursor. */

import { extent, type AxisScale, type Extent } from './axis-scale';
import { edges } from './heat-grid';
import type { Axis, Band, Cursor, Mark, Marker, Numbers, Series } from './types';

const round = (value: number) => Math.round(value * 10) / 10;
/** Far outside of the frame a renderer loses precision. */
const FAR = 20_000;
/** A bar that stands alone. */
const WIDE = 120;
const near = (px: number) => round(Math.min(FAR, Math.max(-FAR, px)));

function* each(numbers: Numbers): Generator<number | null> {
  for (let i = 0; i < numbers.length; i++) yield numbers[i] ?? null;
}

/** Extent of all that is drawn, along one axis. */
export function extentOf(
  way: 'x' | 'y',
  axis: Axis,
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

/** The path of a line or of steps; gaps are gaps. */
export function linePath(line: Pick<Series, 'x' | 'y' | 'kind'>, x: AxisScale, y: AxisScale) {
  const parts: string[] = [];
  let before: number | null = null;
  for (let i = 0; i < line.x.length; i++) {
    const [px, py] = [x.px(line.x[i]), y.px(line.y[i])];
    if (!Number.isFinite(px) || !Number.isFinite(py)) {
      before = null;
      continue;
    }
    if (before === null) parts.push(`M${near(px)} ${near(py)}`);
    else if (line.kind === 'step') parts.push(`H${near(px)}V${near(py)}`);
    else parts.push(`L${near(px)} ${near(py)}`);
    before = py;
  }
  return parts.join('');
}

/** The outline of a band, one closed piece for each stretch without gaps. */
export function bandPath(band: Band, x: AxisScale, y: AxisScale): string {
  const pieces: string[] = [];
  let there: string[] = [];
  let back: string[] = [];
  const close = () => {
    if (there.length > 1) pieces.push(`M${there.join('L')}L${back.reverse().join('L')}Z`);
    [there, back] = [[], []];
  };
  for (let i = 0; i < band.x.length; i++) {
    const [px, low, high] = [x.px(band.x[i]), y.px(band.low[i]), y.px(band.high[i])];
    if ([px, low, high].every(Number.isFinite)) {
      there.push(`${near(px)} ${near(high)}`);
      back.push(`${near(px)} ${near(low)}`);
    } else close();
  }
  close();
  return pieces.join('');
}

/** Bars from zero (of a logarithmic axis, from its foot) to each value. */
export function barsPath(series: Series, x: AxisScale, y: AxisScale): string {
  const at = Array.from({ length: series.x.length }, (_, i) => x.px(series.x[i]));
  const gaps = at.slice(1).flatMap((px, i) => Math.abs(px - (at[i] ?? px)) || []);
  const half = Math.max(0.5, 0.45 * Math.min(WIDE, ...gaps.filter(Number.isFinite)));
  const foot = y.log ? y.pixels[0] : y.px(Math.min(Math.max(0, y.from), y.to));
  return at
    .map((px, i) => {
      const top = y.px(series.y[i]);
      if (!Number.isFinite(px) || !Number.isFinite(top)) return '';
      return `M${near(px - half)} ${near(foot)}V${near(top)}H${near(px + half)}V${near(foot)}Z`;
    })
    .join('');
}

/** Error bars with their caps. */
export function errorsPath(series: Series, x: AxisScale, y: AxisScale): string {
  const parts: string[] = [];
  for (let i = 0; i < series.x.length; i++) {
    const bar = errorEnds(series, i);
    const px = x.px(series.x[i]);
    if (!bar || !Number.isFinite(px)) continue;
    const [low, high] = [y.px(bar[0]), y.px(bar[1])];
    // The foot of a bar that reaches below zero on a logarithmic axis is the foot of the plot.
    const [bottom, top] = [Number.isFinite(low) ? low : y.pixels[0], high];
    if (!Number.isFinite(top)) continue;
    parts.push(
      `M${near(px)} ${near(bottom)}V${near(top)}M${near(px - 3)} ${near(top)}h6M${near(px - 3)} ${near(bottom)}h6`,
    );
  }
  return parts.join('');
}

const SHAPES: Record<Marker, (r: number) => string> = {
  circle: (r) => `m${-r} 0a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0z`,
  square: (r) => `m${-r} ${-r}h${2 * r}v${2 * r}h${-2 * r}z`,
  triangle: (r) => `m0 ${-1.2 * r}l${1.2 * r} ${2 * r}h${-2.4 * r}z`,
  diamond: (r) =>
    `m0 ${-1.3 * r}l${1.3 * r} ${1.3 * r}l${-1.3 * r} ${1.3 * r}l${-1.3 * r} ${-1.3 * r}z`,
  cross: (r) => `m${-r} ${-r}l${2 * r} ${2 * r}m0 ${-2 * r}l${-2 * r} ${2 * r}`,
  plus: (r) => `m${-r} 0h${2 * r}m${-r} ${-r}v${2 * r}`,
};

/** The path of one marker. */
export function markerAt(marker: Marker, px: number, py: number, radius = 3): string {
  return `M${round(px)} ${round(py)}${SHAPES[marker](radius)}`;
}

/** Markers at all points that are inside the frame. */
export function markersPath(series: Series, x: AxisScale, y: AxisScale): string {
  const marker = series.marker ?? 'circle';
  const parts: string[] = [];
  for (let i = 0; i < series.x.length; i++) {
    const [value, at] = [series.y[i], series.x[i]];
    if (!finite(value) || !finite(at) || !x.holds(at) || !y.holds(value)) continue;
    parts.push(markerAt(marker, x.px(at), y.px(value)));
  }
  return parts.join('');
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
  let [best, found] = [Number.POSITIVE_INFINITY, -1];
  for (let i = 0; i < line.x.length; i++) {
    const along = x.px(line.x[i]) - px;
    const across = flat ? (finite(line.y[i]) ? 0 : Number.NaN) : y.px(line.y[i]) - py;
    const distance = along * along + across * across;
    if (distance < best) [best, found] = [distance, i];
  }
  return found;
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
  let i = now < 0 ? (by > 0 ? 0 : last) : Math.min(last, Math.max(0, now + by));
  // Over a gap, to the next point beyond it.
  while (i >= 0 && i <= last && !(finite(series.x[i]) && finite(series.y[i]))) i += Math.sign(by);
  const [px, py] = [series.x[i], series.y[i]];
  return finite(px) && finite(py) ? { x: px, y: py } : at;
}
