/** Series, bands and marks on a canvas: what Plot draws between its axes. */

import { boxOf } from './axes';
import type { AxisScale } from './axis-scale';
import { crisp, markerAt, type Canvas } from './canvas';
import { errorEnds, finite } from './curves';
import type { Band, Look, Mark, Numbers, Series } from './types';

/** A bar that stands alone, CSS pixels. */
const WIDE = 120;
/** Far outside of the frame a renderer loses precision. */
const FAR = 20_000;
const near = (px: number) => Math.min(FAR, Math.max(-FAR, px));

/** The path of a line or of steps; gaps are gaps. */
export function tracePath(
  canvas: Canvas,
  { x: xs, y: ys, kind }: { x: Numbers; y: Numbers; kind?: Look['kind'] },
  x: AxisScale,
  y: AxisScale,
): void {
  const point = (i: number, j: number) => [near(x.px(xs[i])), near(y.px(ys[j]))] as const;
  canvas.c.beginPath();
  if (kind === 'step') canvas.trace(2 * xs.length - 1, (k) => point((k + 1) >> 1, k >> 1));
  else canvas.trace(xs.length, (i) => point(i, i));
}

export function drawBand(canvas: Canvas, band: Band, x: AxisScale, y: AxisScale): void {
  const { c, palette } = canvas;
  const edge = (values: Numbers, i: number) => [x.px(band.x[i]), near(y.px(values[i]))] as const;
  const whole = (i: number) =>
    [...edge(band.low, i), ...edge(band.high, i)].every((px) => Number.isFinite(px));
  c.beginPath();
  for (let i = 0; i < band.x.length; i++) {
    const from = i;
    while (i < band.x.length && whole(i)) i++;
    if (i - from < 2) continue;
    for (let k = from; k < i; k++) {
      const at = edge(band.high, k);
      if (k === from) c.moveTo(...at);
      else c.lineTo(...at);
    }
    for (let k = i - 1; k >= from; k--) c.lineTo(...edge(band.low, k));
    c.closePath();
  }
  const alpha = c.globalAlpha;
  c.globalAlpha = 0.2 * alpha;
  c.fillStyle = palette[band.ink ?? 'reference'];
  c.fill();
  c.globalAlpha = alpha;
  if (band.hatched !== true) return;
  c.fillStyle = canvas.hatch('muted', 0.7);
  c.fill();
}

export function drawSeries(canvas: Canvas, series: Series, x: AxisScale, y: AxisScale): void {
  const { c, palette } = canvas;
  const { kind, ink = 'text', marker, width = 1.6, dash } = series;
  if (kind === 'bars') drawBars(canvas, series, x, y);
  else if (kind !== 'points') {
    if (series.area) drawArea(canvas, series, x, y);
    canvas.pen(ink, width, dash);
    c.lineJoin = 'round';
    tracePath(canvas, series, x, y);
    c.stroke();
  }
  canvas.pen(ink);
  canvas.lines(errorLines(series, x, y));
  if (kind !== 'points' && !marker) return;
  canvas.pen(ink, 1.4);
  c.fillStyle = palette.panel;
  const markers = canvas.shape(markersPath(series, x, y));
  c.fill(markers);
  c.stroke(markers);
}

/** The area between steps and zero. */
function drawArea(
  canvas: Canvas,
  { x: xs, y: ys, ink = 'text', area }: Series,
  x: AxisScale,
  y: AxisScale,
) {
  const { c, palette } = canvas;
  const foot = y.log ? y.pixels[0] : y.px(Math.min(Math.max(0, y.from), y.to));
  c.beginPath();
  for (let i = 1; i < xs.length; i++) {
    const [from, to, top] = [x.px(xs[i - 1]), x.px(xs[i]), near(y.px(ys[i - 1]))];
    if (Number.isFinite(from + to + top)) c.rect(from, top, to - from, foot - top);
  }
  const alpha = c.globalAlpha;
  c.globalAlpha = 0.25 * alpha;
  c.fillStyle = palette[ink];
  c.fill();
  c.globalAlpha = alpha;
  if (area !== 'hatched') return;
  c.fillStyle = canvas.hatch(ink, 0.9);
  c.fill();
}

/** Bars from zero (of a logarithmic axis, from its foot) to each value. */
function drawBars(
  canvas: Canvas,
  { x: xs, y: ys, ink = 'text' }: Series,
  x: AxisScale,
  y: AxisScale,
) {
  const { c, palette } = canvas;
  const at = Array.from({ length: xs.length }, (_, i) => x.px(xs[i]));
  const gaps = at.slice(1).flatMap((px, i) => Math.abs(px - (at[i] ?? px)) || []);
  const half = Math.max(0.5, 0.45 * Math.min(WIDE, ...gaps.filter(Number.isFinite)));
  const foot = y.log ? y.pixels[0] : y.px(Math.min(Math.max(0, y.from), y.to));
  canvas.pen(ink);
  c.beginPath();
  at.forEach((px, i) => {
    const top = near(y.px(ys[i]));
    if (Number.isFinite(px + top)) c.rect(px - half, top, 2 * half, foot - top);
  });
  c.fillStyle = palette[ink];
  const alpha = c.globalAlpha;
  c.globalAlpha = 0.55 * alpha;
  c.fill();
  c.globalAlpha = alpha;
  c.stroke();
}

/** Error bars with their caps. */
function errorLines(series: Series, x: AxisScale, y: AxisScale) {
  return Array.from({ length: series.x.length }, (_, i) => {
    const bar = errorEnds(series, i);
    const px = x.px(series.x[i]);
    if (!bar || !Number.isFinite(px)) return [];
    const [low, top] = [y.px(bar[0]), y.px(bar[1])];
    // The foot of a bar that reaches below zero on a logarithmic axis is the foot of the plot.
    const bottom = Number.isFinite(low) ? low : y.pixels[0];
    if (!Number.isFinite(top)) return [];
    return [
      [px, bottom, px, top],
      [px - 3, top, px + 3, top],
      [px - 3, bottom, px + 3, bottom],
    ] as const;
  }).flat();
}

/** Markers at all points that are inside the frame. */
function markersPath(series: Series, x: AxisScale, y: AxisScale): string {
  let path = '';
  for (let i = 0; i < series.x.length; i++) {
    const [value, at] = [series.y[i], series.x[i]];
    if (!finite(value) || !finite(at) || !x.holds(at) || !y.holds(value)) continue;
    path += markerAt(series.marker ?? 'circle', x.px(at), y.px(value));
  }
  return path;
}

/** Lines across a plot at values of one axis, with their labels: over the curves. */
export function drawMarks(
  canvas: Canvas,
  marks: readonly Mark[],
  x: AxisScale,
  y: AxisScale,
): void {
  const { c, palette } = canvas;
  const { left, right, top, bottom } = boxOf(x, y);
  canvas.font();
  const drawn: { axis: 'x' | 'y'; px: number; row: number }[] = [];
  for (const { axis, at, label, ink = 'muted', dash = 'dash', between } of marks) {
    const [scale, other] = axis === 'x' ? [x, y] : [y, x];
    if (!scale.holds(at)) continue;
    const px = scale.px(at);
    const wide = c.measureText(label).width + 8;
    const rim = palette.panel;
    if (between) {
      const [from, to] = [other.px(between[0]), other.px(between[1])];
      canvas.pen(ink, 2.5, 'solid');
      canvas.lines([axis === 'x' ? [px, from, px, to] : [from, px, to, px]]);
      const early = axis === 'x' && px - wide > left;
      const [across, along] = axis === 'x' ? [px, (from + to) / 2] : [(from + to) / 2, px - 8];
      const align = axis === 'y' ? 'center' : early ? 'right' : 'left';
      const shift = axis === 'y' ? 0 : early ? -6 : 6;
      canvas.write(label, across + shift, along, { align, ink: 'text', rim });
      continue;
    }
    // Labels that would stand on each other go one row further.
    const room = axis === 'x' ? wide : 12;
    const taken = drawn.filter((one) => one.axis === axis && Math.abs(one.px - px) < room);
    let row = 0;
    while (taken.some((one) => one.row === row)) row++;
    drawn.push({ axis, px, row });
    canvas.pen(ink, 1, dash);
    const line = crisp(px);
    canvas.lines([axis === 'x' ? [line, top, line, bottom] : [left, line, right, line]]);
    const late = px + wide > right;
    if (axis === 'x') {
      const align = late ? 'right' : 'left';
      canvas.write(label, px + (late ? -4 : 4), top + 8 + 13 * row, { align, ink: 'text', rim });
    } else {
      const level = px < top + 16 ? px + 9 : px - 8;
      canvas.write(label, right - 4 - 120 * row, level, { align: 'right', ink: 'text', rim });
    }
  }
}
