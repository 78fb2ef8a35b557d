/** Two strips over one axis: a channel of both runs, and their difference with its tolerance. */

import { boxOf, drawAxes, valueTicks, withUnit } from '../../plot/axes';
import { AxisScale } from '../../plot/axis-scale';
import { crisp, markerAt, type Box, type Canvas } from '../../plot/canvas';
import type { Ink } from '../../plot/palette';
import { fit, type Range } from '../../plot/range';
import { drawBand, tracePath } from '../../plot/series-drawing';
import type { PlotAxis } from '../../plot/types';
import type { ComparisonWindow, CurveName } from './comparison-window';

/** Room for the numbers, CSS pixels. */
const LEFT = 66;
const RIGHT = 14;
const FOOT = 22;
const BETWEEN = 30;
const TOP = 6;
/** Least distance between two places of the axis. */
const APART = 70;
const MARKERS = 9;
/** Of the difference's axis, in largest differences: a wide tolerance must not flatten the curve. */
const TALL = 4;

const AXES: Readonly<Record<ComparisonWindow['axis']['name'], PlotAxis>> = {
  time: { label: 'time of 1', unit: 's', scale: { factor: 1, unit: 's' } },
  reference: { label: 'arc length', unit: 'm' },
  index: { label: 'sample', unit: '1' },
};

export interface Pointed {
  cursor: number;
  /** Ends of a drag, places of the axis. */
  selection: Range | null;
  /** Where the largest difference is, and how large. */
  worst: { x: number; y: number; text: string } | null;
}

export class ComparisonChart {
  readonly x: AxisScale;
  private readonly values: AxisScale;
  private readonly differences: AxisScale;

  constructor(
    private readonly canvas: Canvas,
    private readonly window: ComparisonWindow,
  ) {
    const { x, unit, axis } = window;
    const [from, to] = [x[0] ?? 0, x.at(-1) ?? 1];
    const right = Math.max(LEFT + 20, canvas.width - RIGHT);
    this.x = new AxisScale(AXES[axis.name], from, to > from ? to : from + 1, [LEFT, right]);
    const bottom = canvas.height - FOOT;
    const middle = TOP + 0.52 * (bottom - TOP);
    const both = window.extent('baseline', 'candidate') ?? { low: -1, high: 1 };
    const span = fit(both.low, both.high, 1e-9);
    this.values = new AxisScale({ label: '', unit }, span.from, span.to, [
      middle - BETWEEN / 2,
      TOP,
    ]);
    const apart = window.extent('difference') ?? { low: 0, high: 0 };
    const allowed = window.extent('tolerance')?.high ?? 0;
    const largest = Math.max(Math.abs(apart.low), Math.abs(apart.high));
    const room = largest > 0 ? Math.min(allowed, TALL * largest) : allowed;
    const tall = fit(Math.min(apart.low, -room), Math.max(apart.high, room), 1e-9);
    this.differences = new AxisScale({ label: '', unit }, tall.from, tall.to, [
      bottom,
      middle + BETWEEN / 2,
    ]);
  }

  /** Units of both value axes. */
  get units(): readonly [string, string] {
    return [this.values.shown.unit, this.differences.shown.unit];
  }

  /** Top of the lower strip, CSS pixels. */
  get middle(): number {
    return this.differences.pixels[1];
  }

  /** Place of the axis at a pixel. */
  at(px: number): number {
    const [left, right] = this.x.pixels;
    return this.x.at(Math.min(right, Math.max(left, px)));
  }

  draw(pointed: Pointed): void {
    const { canvas, x, values, differences } = this;
    canvas.clear();
    const places = withUnit(x.ticks(APART), x);
    drawAxes(canvas, x, values, { x: places, y: valueTicks(values) }, { bare: true });
    drawAxes(canvas, x, differences, { x: places, y: valueTicks(differences) });
    canvas.clipped(boxOf(x, values), () => {
      this.trace('baseline', values, 'baseline', 2);
      this.trace('candidate', values, 'candidate', 1.4);
      this.diamonds();
    });
    canvas.clipped(boxOf(x, differences), () => {
      this.tolerance();
      this.beyond();
      this.trace('difference', differences, 'difference', 1.4);
    });
    this.worst(pointed);
    this.pointer(pointed);
  }

  /** A curve from least to largest of each bin. */
  private trace(name: CurveName, y: AxisScale, ink: Ink, width: number): void {
    const { minimum, maximum } = this.window.curve(name);
    const count = minimum.length;
    const [xs, ys] = [new Float64Array(2 * count), new Float64Array(2 * count)];
    for (let i = 0; i < count; i++) {
      xs[2 * i] = xs[2 * i + 1] = this.window.x[i] as number;
      ys[2 * i] = minimum[i] as number;
      ys[2 * i + 1] = maximum[i] as number;
    }
    this.canvas.pen(ink, width);
    this.canvas.c.lineJoin = 'round';
    tracePath(this.canvas, { x: xs, y: ys }, this.x, y);
    this.canvas.c.stroke();
  }

  /** Diamonds tell 2 from 1 without colour. */
  private diamonds(): void {
    const { canvas, window } = this;
    const { minimum, maximum } = window.curve('candidate');
    const { c } = canvas;
    c.fillStyle = canvas.palette.candidate;
    for (let k = 0; k < MARKERS; k++) {
      const i = Math.floor(((k + 0.5) / MARKERS) * minimum.length);
      const value = ((minimum[i] as number) + (maximum[i] as number)) / 2;
      if (!Number.isFinite(value)) continue;
      c.fill(new Path2D(markerAt('diamond', this.x.px(window.x[i]), this.values.px(value), 3)));
    }
  }

  private tolerance(): void {
    const { canvas, window, x, differences } = this;
    const high = window.curve('tolerance').minimum;
    if (!high.some((value) => value > 0)) return;
    const low = high.map((value) => -value);
    drawBand(canvas, { name: '', x: window.x, low, high, ink: 'good' }, x, differences);
    canvas.pen('good', 1, 'dot');
    for (const y of [low, high]) {
      tracePath(canvas, { x: window.x, y }, x, differences);
      canvas.c.stroke();
    }
  }

  /** Hatching where something is beyond the tolerance. */
  private beyond(): void {
    const { canvas, window, x } = this;
    const { top, bottom } = boxOf(x, this.differences);
    canvas.c.fillStyle = canvas.hatch('bad', 1);
    for (const { from, to } of window.excursions()) {
      const left = x.px(window.x[from]);
      const right = x.px(window.x[Math.min(to, window.x.length - 1)]);
      canvas.c.fillRect(left, top, Math.max(2, right - left), bottom - top);
    }
  }

  private worst({ worst }: Pointed): void {
    const { canvas, x, differences } = this;
    if (!worst || !x.holds(worst.x)) return;
    const [px, py] = [x.px(worst.x), differences.px(worst.y)];
    const box: Box = boxOf(x, differences);
    canvas.pen('text', 1.5);
    canvas.c.beginPath();
    canvas.c.arc(px, Math.min(box.bottom, Math.max(box.top, py)), 4, 0, 2 * Math.PI);
    canvas.c.stroke();
    canvas.font(11, 600);
    const late = px > (box.left + box.right) / 2;
    const level = Math.min(box.bottom - 8, Math.max(box.top + 8, py));
    canvas.write(worst.text, px + (late ? -9 : 9), level, {
      align: late ? 'right' : 'left',
      ink: 'text',
      rim: canvas.palette.panel,
    });
  }

  private pointer({ cursor, selection }: Pointed): void {
    const { canvas, x } = this;
    const [top, bottom] = [TOP, this.differences.pixels[0]];
    if (selection) {
      const [from, to] = [x.px(selection.from), x.px(selection.to)];
      canvas.c.globalAlpha = 0.18;
      canvas.c.fillStyle = canvas.palette.focus;
      canvas.c.fillRect(from, top, to - from, bottom - top);
      canvas.c.globalAlpha = 1;
    }
    if (!x.holds(cursor)) return;
    const at = crisp(x.px(cursor));
    canvas.pen('strong');
    canvas.lines([[at, top, at, bottom]]);
  }
}
