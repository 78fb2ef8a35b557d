/** Strips of speed, velocity, acceleration and thrust over time, each against its limits. */

import { drawAxes, withUnit } from '../../plot/axes';
import { AxisScale } from '../../plot/axis-scale';
import { crisp, type Canvas } from '../../plot/canvas';
import { calmRange, type Range } from '../../plot/range';
import { TIME } from '../../plot/scope-chart';
import { StillSource, type Envelope } from '../../plot/source';
import { SourceCurve } from '../../plot/source-curve';
import type { Look } from '../../plot/types';
import { stretches, type Checked, type Limited } from './feasibility';

interface Drawn {
  column: string;
  look: Look;
}

export interface Strip {
  title: string;
  unit: string;
  /** Curves by column; x solid, y dashed. */
  curves: readonly Drawn[];
  /** Columns whose extremes bound the curves of an axis. */
  bounds?: readonly Drawn[];
  quantities: readonly Limited[];
}

export const STRIPS: readonly Strip[] = [
  {
    title: 'speed',
    unit: 'm/s',
    curves: [{ column: 'speed', look: { ink: 'text', width: 1.4 } }],
    quantities: [],
  },
  {
    title: 'velocity',
    unit: 'm/s',
    curves: axes('velocity'),
    quantities: ['velocity', 'step'],
  },
  {
    title: 'acceleration',
    unit: 'm/s^2',
    curves: axes('acceleration'),
    quantities: ['acceleration'],
  },
  {
    title: 'thrust',
    unit: 'N',
    curves: axes('thrust'),
    bounds: [
      { column: 'x.available_thrust', look: { ink: 'phase-a', dash: 'dot', width: 1.2 } },
      { column: 'y.available_thrust', look: { ink: 'phase-b', dash: 'dot', width: 1.2 } },
    ],
    quantities: ['thrust'],
  },
];

const LEFT = 58;
const RIGHT = 8;
const BOTTOM = 18;
const TITLE = 15;
/** Limits that are further away than this many times the largest value are not drawn. */
const FAR = 2.5;
/** Width of a bin of limits, CSS pixels. */
const RIPPLE = 4;
/** Least distances of values and of times, CSS pixels. */
const [ROW, COLUMN] = [18, 56];

function axes(quantity: string): Strip['curves'] {
  return [
    { column: `x.${quantity}`, look: { ink: 'phase-a', width: 1.4 } },
    { column: `y.${quantity}`, look: { ink: 'phase-b', width: 1.4, dash: 'dash' } },
  ];
}

export class ProfileStrips {
  private readonly ranges = new Map<string, Range>();

  constructor(private readonly canvas: Canvas) {}

  /** Returns the bin under a pointer at `px`, or null beside the strips. */
  binAt(px: number, count: number): number | null {
    const share = (px - LEFT) / (this.canvas.width - LEFT - RIGHT);
    return share >= 0 && share <= 1 ? Math.min(count - 1, Math.floor(share * count)) : null;
  }

  draw(checked: Checked, fresh: boolean, cursor: number | null): void {
    const { canvas } = this;
    const { step, count } = checked.time;
    const right = Math.max(LEFT + 1, canvas.width - RIGHT);
    const x = new AxisScale(TIME, 0, step * count, [LEFT, right]);
    canvas.clear();
    canvas.c.globalAlpha = fresh ? 1 : 0.7;
    const floor = canvas.height - BOTTOM;
    const strips = STRIPS.filter(({ curves }) =>
      curves.some(({ column }) => checked.columns.has(column)),
    );
    const each = floor / strips.length;
    strips.forEach((strip, i) => {
      const last = i === strips.length - 1;
      this.strip(checked, strip, x, [last ? floor : (i + 1) * each - 4, i * each + TITLE], last);
    });
    canvas.c.globalAlpha = 1;
    if (cursor === null) return;
    const at = crisp(x.px((cursor + 0.5) * step));
    canvas.pen('focus');
    canvas.lines([[at, 0, at, floor]]);
  }

  private strip(
    checked: Checked,
    strip: Strip,
    x: AxisScale,
    pixels: readonly [bottom: number, top: number],
    last: boolean,
  ): void {
    const { canvas } = this;
    const { step, count } = checked.time;
    const [left, right] = x.pixels;
    const [bottom, top] = pixels;
    const source = new StillSource(0, step, count, checked.columns);
    const bins = source.cut(0, step * count, right - left);
    const curves = strip.curves
      .filter(({ column }) => source.has(column))
      .map(({ column, look }) => new SourceCurve(column, look));
    let [low, high] = [0, 0];
    const hold = (...values: number[]) => {
      [low, high] = [Math.min(low, ...values), Math.max(high, ...values)];
    };
    for (const curve of curves) hold(...curve.read(source, bins));
    const far = FAR * Math.max(-low, high);
    const limits = limitsOf(checked, strip).filter((value) => value <= far);
    hold(...limits, ...limits.map((value) => -value));
    const bounds = (strip.bounds ?? []).flatMap(({ column, look }) => {
      const values = checked.columns.get(column);
      return values && most(values.maximum) <= far ? [{ values, look }] : [];
    });
    for (const { values } of bounds) hold(least(values.minimum), most(values.maximum));
    const range = calmRange(this.ranges.get(strip.title) ?? null, low, high);
    this.ranges.set(strip.title, range);
    // Accelerations in one unit, as in the panel of limits.
    const scale = strip.unit === 'm/s^2' ? { scale: { factor: 1, unit: 'm/s²' } } : {};
    const y = new AxisScale(
      { label: '', unit: strip.unit, ...scale },
      range.from,
      range.to,
      pixels,
    );

    canvas.c.fillStyle = canvas.hatch('bad');
    for (const [from, to] of stretches(checked, strip.quantities)) {
      const [start, end] = [x.px(from * step), x.px(to * step)];
      canvas.c.fillRect(start - 1, top, Math.max(3, end - start + 2), bottom - top);
    }
    const times = last ? x.ticks(COLUMN).filter(({ value }) => x.px(value) <= right - 16) : [];
    const values = y.ticks(Math.min(ROW, (bottom - top) / 4));
    drawAxes(canvas, x, y, { x: withUnit(times, x), y: values });
    this.title(strip, y, top - 8);
    canvas.pen('bad');
    canvas.lines(
      limits
        .flatMap((value) => [y.px(value), y.px(-value)])
        .map((at) => [left, at, right, at] as const),
    );
    const size = Math.max(1, Math.ceil((RIPPLE * count) / (right - left)));
    for (const { values, look } of bounds) {
      for (const side of tightest(values, size)) {
        canvas.pen(look.ink ?? 'text', look.width, look.dash);
        canvas.c.beginPath();
        canvas.trace(side.length, (i) => [x.px((i + 0.5) * size * step), y.px(side[i])]);
        canvas.c.stroke();
      }
    }
    for (const curve of curves) curve.draw(canvas, source, x, y);
  }

  private title({ title }: Strip, { shown }: AxisScale, y: number): void {
    const { canvas } = this;
    canvas.font(11, 600);
    canvas.write(title, LEFT, y, { ink: 'text' });
    const wide = canvas.c.measureText(title).width;
    canvas.font();
    canvas.write(shown.unit, LEFT + wide + 6, y, { ink: 'axis' });
  }
}

/** The least that is left either way in bins of some samples: limits ripple faster than pixels. */
export function tightest(
  { minimum, maximum }: Envelope,
  size: number,
): [Float32Array, Float32Array] {
  const bins = Math.ceil(minimum.length / size);
  const of = (values: Float32Array, pick: (...values: number[]) => number) =>
    Float32Array.from({ length: bins }, (_, i) =>
      pick(...values.subarray(i * size, (i + 1) * size)),
    );
  return [of(minimum, Math.max), of(maximum, Math.min)];
}

/** The limits of a quantity, each once: they hold in both directions. */
function limitsOf({ peaks }: Checked, { title, bounds }: Strip): number[] {
  if (bounds) return [];
  const all = peaks.flatMap(({ quantity, limit }) =>
    quantity === title && limit !== null ? [Math.abs(limit)] : [],
  );
  return [...new Set(all)];
}

function least(values: Envelope['minimum']): number {
  return values.reduce((a, b) => Math.min(a, b), Number.POSITIVE_INFINITY);
}

function most(values: Envelope['maximum']): number {
  return values.reduce((a, b) => Math.max(a, b), Number.NEGATIVE_INFINITY);
}
