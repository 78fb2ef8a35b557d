/** A plane seen from above: a metre is as long on both axes; a round grid with numbers. */

import { minus, scaleFor } from '../ui/units';
import { crisp, type Box, type Canvas } from './canvas';
import { multiples, roundStep } from './range';

/** Room for the numbers of both axes, CSS pixels. */
const MARGIN = { left: 58, right: 14, top: 6, bottom: 20 };
/** Least distance of two lines of the grid. */
const APART = 46;

export type Point = readonly [x: number, y: number];

export class Plane {
  /** The place in the middle, m. */
  centre: Point = [0, 0];
  /** CSS pixels per metre. */
  scale = 1;

  constructor(private readonly canvas: Canvas) {}

  /** The part within the numbers. */
  get box(): Box {
    const { width, height } = this.canvas;
    const { left, right, bottom } = MARGIN;
    return { left, right: width - right, top: 0, bottom: height - bottom };
  }

  /** The scale at which so many metres fit. */
  fitting(width: number, height: number): number {
    const { left, right, top, bottom } = MARGIN;
    return Math.min(
      (this.canvas.width - left - right) / Math.max(1e-9, width),
      (this.canvas.height - top - bottom) / Math.max(1e-9, height),
    );
  }

  px(x: number): number {
    const { left, right } = MARGIN;
    return (this.canvas.width + left - right) / 2 + (x - this.centre[0]) * this.scale;
  }

  py(y: number): number {
    const { top, bottom } = MARGIN;
    return (this.canvas.height + top - bottom) / 2 - (y - this.centre[1]) * this.scale;
  }

  /** Returns which place is at some pixels. */
  place([px, py]: Point): Point {
    return [(px - this.px(0)) / this.scale, (this.py(0) - py) / this.scale];
  }

  grid(): void {
    const { c, palette } = this.canvas;
    const { left, right, top, bottom } = this.box;
    const [west, north] = this.place([left, top]);
    const [east, south] = this.place([right, bottom]);
    const step = roundStep(APART / this.scale);
    const { factor, unit } = scaleFor(Math.max(step * 2, Math.abs(north)), 'm');
    const places = Math.max(0, Math.ceil(-Math.log10(step * factor) - 1e-9));
    const text = (value: number, last: boolean) =>
      minus((value * factor).toFixed(places)) + (last ? ` ${unit}` : '');
    c.strokeStyle = palette.grid;
    c.fillStyle = palette.axis;
    c.lineWidth = 1;
    c.setLineDash([]);
    this.canvas.font();
    c.textBaseline = 'middle';
    c.textAlign = 'right';
    c.beginPath();
    const levels = multiples({ from: south, to: north }, step).filter((y) => this.py(y) > 8);
    levels.forEach((y, i) => {
      const at = crisp(this.py(y));
      c.moveTo(left, at);
      c.lineTo(right, at);
      c.fillText(text(y, i === levels.length - 1), left - 6, at);
    });
    c.textAlign = 'center';
    const columns = multiples({ from: west, to: east }, step);
    const fits = (x: number) => this.px(x) > left + 8 && this.px(x) < right - 10;
    const last = columns.filter(fits).at(-1);
    for (const x of columns) {
      const at = crisp(this.px(x));
      c.moveTo(at, top);
      c.lineTo(at, bottom);
      if (fits(x)) c.fillText(text(x, x === last), at, bottom + 12);
    }
    c.stroke();
  }
}
