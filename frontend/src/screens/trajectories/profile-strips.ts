/** Strips of speed, velocity, acceleration and thrust over time, each against its limits. */

import { Canvas, crisp, hatching } from '../../plot/canvas';
import type { Palette } from '../../plot/palette';
import { calmRange, multiples, roundStep, type Range } from '../../plot/range';
import type { Envelope } from '../../plot/source';
import { minus, scaleFor } from '../../ui/units';
import { stretches, type Checked, type Limited } from './feasibility';

export interface Strip {
  title: string;
  unit: string;
  /** Curves by column; x solid, y dashed. */
  curves: readonly { column: string; ink: 'phase-a' | 'phase-b' | 'text'; dashed?: boolean }[];
  /** Columns whose extremes bound the curves of an axis. */
  bounds?: readonly { column: string; ink: 'phase-a' | 'phase-b' }[];
  quantities: readonly Limited[];
}

export const STRIPS: readonly Strip[] = [
  {
    title: 'speed',
    unit: 'm/s',
    curves: [{ column: 'speed', ink: 'text' }],
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
      { column: 'x.available_thrust', ink: 'phase-a' },
      { column: 'y.available_thrust', ink: 'phase-b' },
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
/** A curve that goes up and down this many times its width is dense. */
const DENSE = 4;

function axes(quantity: string): Strip['curves'] {
  return [
    { column: `x.${quantity}`, ink: 'phase-a' },
    { column: `y.${quantity}`, ink: 'phase-b', dashed: true },
  ];
}

export class ProfileStrips {
  private readonly ranges = new Map<string, Range>();
  private readonly canvas: Canvas;
  private readonly c: CanvasRenderingContext2D;
  private readonly inks: Palette;
  private readonly hatch: CanvasPattern | null;

  constructor(element: HTMLCanvasElement, palette: Palette) {
    this.canvas = new Canvas(element, palette);
    this.c = this.canvas.c;
    this.inks = palette;
    this.hatch = hatching(this.c, palette.bad);
  }

  resize(width: number, height: number): void {
    this.canvas.resize(width, height);
  }

  /** Returns the bin under a pointer at `px`, or null beside the strips. */
  binAt(px: number, count: number): number | null {
    const share = (px - LEFT) / (this.canvas.width - LEFT - RIGHT);
    return share >= 0 && share <= 1 ? Math.min(count - 1, Math.floor(share * count)) : null;
  }

  draw(found: Checked, fresh: boolean, cursor: number | null): void {
    const { c } = this;
    this.canvas.clear();
    c.globalAlpha = fresh ? 1 : 0.7;
    const each = (this.canvas.height - BOTTOM) / STRIPS.length;
    STRIPS.forEach((strip, i) => {
      this.strip(found, strip, i * each + TITLE, (i + 1) * each - 4);
    });
    c.globalAlpha = 1;
    this.time(found);
    if (cursor === null) return;
    const at = crisp(this.px(cursor + 0.5, found.time.count));
    c.lineWidth = 1;
    this.canvas.line([at, 0], [at, this.canvas.height - BOTTOM], this.inks.focus);
  }

  private px(bin: number, count: number): number {
    return LEFT + (bin / count) * (this.canvas.width - LEFT - RIGHT);
  }

  private strip(found: Checked, strip: Strip, top: number, bottom: number): void {
    const { c, inks } = this;
    const curves = strip.curves.flatMap((curve) => {
      const values = found.columns.get(curve.column);
      return values ? [{ ...curve, values }] : [];
    });
    let [low, high] = [0, 0];
    for (const { values } of curves) {
      low = Math.min(low, least(values.minimum));
      high = Math.max(high, most(values.maximum));
    }
    const far = FAR * Math.max(-low, high);
    const limits = this.limits(found, strip).filter(({ value }) => Math.abs(value) <= far);
    for (const { column } of strip.bounds ?? []) {
      const values = found.columns.get(column);
      if (!values || most(values.maximum) > far) continue;
      [low, high] = [Math.min(low, least(values.minimum)), Math.max(high, most(values.maximum))];
    }
    for (const { value } of limits) [low, high] = [Math.min(low, value), Math.max(high, value)];
    const range = calmRange(this.ranges.get(strip.title) ?? null, low, high);
    this.ranges.set(strip.title, range);
    const py = (value: number) =>
      bottom - ((value - range.from) / (range.to - range.from)) * (bottom - top);

    for (const [from, to] of stretches(found, strip.quantities)) {
      const [left, right] = [this.px(from, found.time.count), this.px(to, found.time.count)];
      c.fillStyle = this.hatch ?? inks.bad;
      c.fillRect(left - 1, top, Math.max(3, right - left + 2), bottom - top);
    }
    this.axis(strip, range, top, bottom, py);
    c.lineWidth = 1;
    for (const { value, ink } of limits) this.line(py(value), inks[ink]);
    this.bounds(found, strip, far, py);
    for (const { values, ink, dashed } of curves) {
      const { count } = found.time;
      if (this.travelled(values, count, py) > DENSE * (this.canvas.width - LEFT - RIGHT)) {
        c.fillStyle = inks[ink];
        this.bars(values, count, py);
        continue;
      }
      c.strokeStyle = inks[ink];
      c.lineWidth = 1.4;
      c.setLineDash(dashed === true ? [5, 3] : []);
      this.curve(values, count, py);
      c.setLineDash([]);
    }
  }

  private limits(found: Checked, { title, bounds }: Strip): { value: number; ink: 'bad' }[] {
    if (bounds) return [];
    const all = found.peaks.flatMap(({ quantity, limit }) =>
      quantity === title && limit !== null ? [limit] : [],
    );
    return [...new Set(all)].flatMap((value) => [
      { value, ink: 'bad' as const },
      { value: -value, ink: 'bad' as const },
    ]);
  }

  /** What is available at each place, for each axis: a thin line above and below. */
  private bounds(
    found: Checked,
    { bounds = [] }: Strip,
    far: number,
    py: (value: number) => number,
  ): void {
    const { c, inks } = this;
    const { count } = found.time;
    for (const { column, ink } of bounds) {
      const values = found.columns.get(column);
      if (!values || most(values.maximum) > far) continue;
      c.strokeStyle = inks[ink];
      c.lineWidth = 0.8;
      c.setLineDash(ink === 'phase-b' ? [2, 3] : [1, 2]);
      for (const side of [values.minimum, values.maximum]) {
        c.beginPath();
        this.canvas.trace(count, (i) => [this.px(i + 0.5, count), py(side[i] as number)]);
        c.stroke();
      }
      c.setLineDash([]);
    }
  }

  private axis(
    { title, unit }: Strip,
    range: Range,
    top: number,
    bottom: number,
    py: (value: number) => number,
  ): void {
    const { c, inks } = this;
    const scale = scaleFor(Math.max(-range.from, range.to), unit);
    const step = roundStep((range.to - range.from) / Math.max(4, (bottom - top) / 18));
    const places = Math.max(0, Math.ceil(-Math.log10(step * scale.factor) - 1e-9));
    this.canvas.font();
    c.textBaseline = 'middle';
    c.textAlign = 'right';
    c.lineWidth = 1;
    for (const value of multiples(range, step)) {
      const at = crisp(py(value));
      this.line(at, value === 0 ? inks.strong : inks.grid);
      c.fillStyle = inks.axis;
      c.fillText(minus((value * scale.factor).toFixed(places)), LEFT - 5, at);
    }
    c.textAlign = 'left';
    c.fillStyle = inks.text;
    this.canvas.font(11, 600);
    c.fillText(title, LEFT, top - 8);
    const wide = c.measureText(title).width;
    this.canvas.font();
    c.fillStyle = inks.axis;
    c.fillText(scale.unit, LEFT + wide + 6, top - 8);
  }

  private line(at: number, colour: string): void {
    this.canvas.line([LEFT, at], [this.canvas.width - RIGHT, at], colour);
  }

  private curve({ minimum, maximum }: Envelope, count: number, py: (v: number) => number): void {
    const { c } = this;
    let pen = py(0);
    c.beginPath();
    for (let i = 0; i < count; i++) {
      const at = this.px(i + 0.5, count);
      const [low, high] = [py(minimum[i] as number), py(maximum[i] as number)];
      // From the end of the bin that is nearer to where the pen is: no zigzag on a slope.
      const [first, last] = Math.abs(low - pen) <= Math.abs(high - pen) ? [low, high] : [high, low];
      if (i === 0) c.moveTo(at, first);
      else c.lineTo(at, first);
      if (first !== last) c.lineTo(at, last);
      pen = last;
    }
    c.stroke();
  }

  /** Returns how far a pen goes up and down along a curve, CSS pixels. */
  private travelled(
    { minimum, maximum }: Envelope,
    count: number,
    py: (v: number) => number,
  ): number {
    let way = 0;
    let before = py(0);
    for (let i = 0; i < count; i++) {
      const [low, high] = [py(minimum[i] as number), py(maximum[i] as number)];
      way += Math.abs(low - high) + Math.abs(low - before);
      before = high;
    }
    return way;
  }

  /** Fills what a dense curve covers, pixel by pixel: a line to and fro would take ten times as long. */
  private bars({ minimum, maximum }: Envelope, count: number, py: (v: number) => number): void {
    let column = Number.NaN;
    let [top, bottom] = [0, 0];
    const fill = () => this.c.fillRect(column, top - 0.5, 1, bottom - top + 1);
    for (let i = 0; i < count; i++) {
      const at = Math.floor(this.px(i + 0.5, count));
      const [low, high] = [py(minimum[i] as number), py(maximum[i] as number)];
      if (at !== column) {
        if (i > 0) fill();
        // A bar reaches as far as the one before it, so that none stands alone.
        [top, bottom] = i > 0 ? [Math.min(high, bottom), Math.max(low, top)] : [high, low];
        column = at;
      } else {
        [top, bottom] = [Math.min(top, high), Math.max(bottom, low)];
      }
    }
    fill();
  }

  private time(found: Checked): void {
    const { c, inks } = this;
    const end = found.time.step * found.time.count;
    const step = roundStep(end / Math.max(2, (this.canvas.width - LEFT) / 56));
    const places = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
    this.canvas.font();
    c.fillStyle = inks.axis;
    c.textAlign = 'center';
    c.textBaseline = 'middle';
    const shown = multiples({ from: 0, to: end }, step)
      .map((time) => ({ time, at: LEFT + (time / end) * (this.canvas.width - LEFT - RIGHT) }))
      .filter(({ at }) => at <= this.canvas.width - 24);
    shown.forEach(({ time, at }, i) => {
      const text = time.toFixed(places);
      c.fillText(i === shown.length - 1 ? `${text} s` : text, at, this.canvas.height - 8);
    });
  }
}

function least(values: Float32Array): number {
  return values.reduce((a, b) => Math.min(a, b), Number.POSITIVE_INFINITY);
}

function most(values: Float32Array): number {
  return values.reduce((a, b) => Math.max(a, b), Number.NEGATIVE_INFINITY);
}
