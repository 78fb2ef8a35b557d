/** A plane seen from above: a metre is as long on both axes; a round grid with numbers. */

import { scaleFor } from '../ui/units';
import { drawAxes, withUnit } from './axes';
import { AxisScale, type Tick } from './axis-scale';
import type { Box, Canvas } from './canvas';

/** Room for the numbers of both axes, CSS pixels. */
const MARGIN = { left: 58, right: 14, top: 6, bottom: 20 };
/** Least distance of two lines of the grid. */
const APART = 46;
const METRES = { label: '', unit: 'm' };

export type PlanePoint = readonly [x: number, y: number];

export class Plane {
  /** The place in the middle, m. */
  centre: PlanePoint = [0, 0];
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
  place([px, py]: PlanePoint): PlanePoint {
    return [(px - this.px(0)) / this.scale, (this.py(0) - py) / this.scale];
  }

  /** A round grid with numbers, each where there is room for it. */
  grid(): void {
    const { left, right, top, bottom } = this.box;
    const [west, north] = this.place([left, top]);
    const [east, south] = this.place([right, bottom]);
    const shown = scaleFor(Math.max((2 * APART) / this.scale, Math.abs(north)), 'm');
    const x = new AxisScale(METRES, west, east, [left, right], shown);
    const y = new AxisScale(METRES, south, north, [bottom, top], shown);
    const fits = ({ value }: Tick) => x.px(value) > left - 2 && x.px(value) < right - 10;
    const columns = x.ticks(APART);
    const named = new Map(withUnit(columns.filter(fits), x).map((tick) => [tick.value, tick]));
    const levels = y.ticks(APART).filter(({ value }) => y.px(value) > 8);
    const ticks = {
      x: columns.map((tick) => named.get(tick.value) ?? { ...tick, text: ' ' }),
      y: withUnit(levels, y),
    };
    drawAxes(this.canvas, x, y, ticks, { zero: false });
  }
}
