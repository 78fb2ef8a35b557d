/** Grid, ticks, numbers and names of two axes, around every plot. */

import type { AxisScale, Tick } from './axis-scale';
import { crisp, type Box, type Canvas, type Segment } from './canvas';
import { multiples, roundStep } from './range';

/** Least distance between two values, CSS pixels. */
const ROW = 24;

export interface AxesLook {
  /** No numbers below: another plot beneath has them. */
  bare?: boolean;
  grid?: boolean;
  /** Tick marks, a base line and the names of the axes. */
  framed?: boolean;
  /** Whether the line at zero is stronger than others. */
  zero?: boolean;
}

/** The part between the axes. */
export function boxOf(x: AxisScale, y: AxisScale): Box {
  const [left, right] = x.pixels;
  const [bottom, top] = y.pixels;
  return { left, right, top, bottom };
}

/** Ticks of a value axis; where there is little room its ends, where these are round, and zero. */
export function valueTicks(scale: AxisScale): Tick[] {
  const { from, to } = scale;
  const height = Math.abs(scale.pixels[1] - scale.pixels[0]);
  const ticks = scale.ticks(Math.max(ROW, height / 6));
  if (height >= 2.5 * ROW && ticks.length > 2) return withUnit(ticks, scale);
  const apart = 0.35 * (to - from);
  const few = roundEnds(scale);
  const [low = from, high = to] = few;
  const values = -low > apart && high > apart ? [low, 0, high] : few;
  return withUnit(scale.named(values), scale);
}

/** The ends of an axis; of one that was zoomed or moved, round values near them. */
function roundEnds({ from, to }: AxisScale): number[] {
  const span = to - from;
  const fine = roundStep(span / 100);
  const round = [from, to].every((end) => Math.abs(end / fine - Math.round(end / fine)) < 1e-6);
  if (round) return [from, to];
  // The coarsest step whose first and last multiple are far enough from each other.
  for (let step = roundStep(span); step > fine; step = roundStep(step / 2.5)) {
    const [low = 0, ...more] = multiples({ from, to }, step);
    const high = more.at(-1) ?? low;
    if (high - low >= 0.6 * span) return [low, high];
  }
  return [from, to];
}

/** The ticks with the unit at the last: for axes without a name. */
export function withUnit(ticks: readonly Tick[], { shown }: AxisScale): Tick[] {
  return ticks.map((tick, i) =>
    i === ticks.length - 1 ? { ...tick, text: `${tick.text} ${shown.unit}`.trimEnd() } : tick,
  );
}

export function drawAxes(
  canvas: Canvas,
  x: AxisScale,
  y: AxisScale,
  ticks: { x: readonly Tick[]; y: readonly Tick[] },
  { bare = false, grid = true, framed = false, zero = true }: AxesLook = {},
): void {
  const { c } = canvas;
  const { left, right, top, bottom } = boxOf(x, y);
  const upright = ticks.x.map(({ value, text }) => ({ text, at: crisp(x.px(value)) }));
  const level = ticks.y.map(({ value, text }) => ({ value, text, at: crisp(y.px(value)) }));
  canvas.font();
  if (grid) {
    const lines = (fine: boolean): Segment[] => [
      ...upright
        .filter(({ text }) => (text === '') === fine)
        .map(({ at }) => [at, top, at, bottom] as const),
      ...level
        .filter(({ text }) => (text === '') === fine)
        .map(({ at }) => [left, at, right, at] as const),
    ];
    canvas.pen('grid');
    canvas.lines(lines(false));
    const fine = lines(true);
    if (fine.length > 0) {
      const alpha = c.globalAlpha;
      c.globalAlpha = 0.55 * alpha;
      canvas.lines(fine);
      c.globalAlpha = alpha;
    }
    const middle = zero ? level.find(({ value }) => value === 0) : undefined;
    canvas.pen('strong');
    if (middle) canvas.lines([[left, middle.at, right, middle.at]]);
  }
  if (framed) {
    canvas.pen('strong');
    canvas.lines([
      ...upright.map(({ at, text }) => [at, bottom, at, bottom + (text ? 4 : 2)] as const),
      ...level.map(({ at, text }) => [left, at, left - (text ? 4 : 2), at] as const),
      [crisp(left), top, crisp(left), crisp(bottom)],
      [left, crisp(bottom), right, crisp(bottom)],
    ]);
    drawName(canvas, x, (left + right) / 2, bottom + 27);
    drawName(canvas, y, 7, (top + bottom) / 2, true);
  }
  for (const { at, text } of bare ? [] : upright) {
    canvas.write(text, at, bottom + 11, { align: 'center', ink: 'axis' });
  }
  for (const { at, text } of level) {
    // More digits than there is room for reach into the plot, not beyond the edge.
    const width = Number(c.measureText(text)?.width);
    const long = width > left - 8;
    const rim = long ? { rim: canvas.palette.panel } : {};
    canvas.write(text, long ? width + 2 : left - 6, at, { align: 'right', ink: 'axis', ...rim });
  }
}

/** A name with its subscript and its unit around a place: `k_p x` as in ui/Symbol. */
export function drawName(
  canvas: Canvas,
  { label, shown: { unit } }: AxisScale,
  x: number,
  y: number,
  upright = false,
): void {
  const { c } = canvas;
  const parts = label
    .split(/_(\w+)/)
    .map((text, i) => ({ text, size: i % 2 ? 9 : 11, drop: i % 2 ? 3 : 0, ink: 'text' as const }));
  const all = unit
    ? [...parts, { text: ` ${unit}`, size: 11, drop: 0, ink: 'muted' as const }]
    : parts;
  const widths = all.map(({ text, size }) => {
    canvas.font(size);
    return c.measureText(text).width;
  });
  c.save();
  c.translate(x, y);
  if (upright) c.rotate(-Math.PI / 2);
  let at = -widths.reduce((sum, width) => sum + width, 0) / 2;
  all.forEach(({ text, size, drop, ink }, i) => {
    canvas.font(size);
    canvas.write(text, at, drop, { ink });
    at += widths[i] as number;
  });
  c.restore();
  canvas.font();
}
