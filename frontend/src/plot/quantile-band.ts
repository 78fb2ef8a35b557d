/** Bands behind the curves of a scope: how one quantity is spread over many runs. */

import type { AxisScale } from './axis-scale';
import type { Canvas } from './canvas';
import type { Ink } from './palette';
import type { Range } from './range';
import type { Dash } from './types';
import { nextVersion, type Underlay } from './run-overlay';

export interface QuantileBand {
  /** Of the curve that it is of. */
  column: string;
  ink: Ink;
  /** Dashes of the edges: they distinguish B from A without colour. */
  dash: Dash;
  time: readonly number[];
  least: readonly number[];
  low: readonly number[];
  high: readonly number[];
  most: readonly number[];
}

const FAINT = 0.1;
const SHADE = 0.2;
const EDGES = 0.5;

/** A band as what lies behind curves. */
export class BandUnderlay implements Underlay {
  readonly version = nextVersion();

  readonly column: string;

  constructor(private readonly band: QuantileBand) {
    this.column = band.column;
  }

  read(range: Range): readonly [number, number] {
    return bandExtremes(this.band, range);
  }

  draw(canvas: Canvas, x: AxisScale, y: AxisScale): void {
    drawQuantileBand(canvas, this.band, x, y);
  }
}

/** Returns the least and the largest value over a range of time. */
function bandExtremes({ time, least, most }: QuantileBand, { from, to }: Range) {
  let low = Number.POSITIVE_INFINITY;
  let high = Number.NEGATIVE_INFINITY;
  time.forEach((at, k) => {
    if (at < from || at > to) return;
    low = Math.min(low, least[k] as number);
    high = Math.max(high, most[k] as number);
  });
  return [low, high] as const;
}

/** Draws from least to most, faint, and from low to high, stronger and with edges. */
function drawQuantileBand(
  canvas: Canvas,
  { ink, dash, time, least, low, high, most }: QuantileBand,
  x: AxisScale,
  y: AxisScale,
): void {
  const { c, palette } = canvas;
  const line = (values: readonly number[], back = false) => {
    for (let i = 0; i < time.length; i++) {
      const k = back ? time.length - 1 - i : i;
      c.lineTo(x.px(time[k]), y.px(values[k]));
    }
  };
  const area = (bottom: readonly number[], top: readonly number[], alpha: number) => {
    c.globalAlpha = alpha;
    c.beginPath();
    line(bottom);
    line(top, true);
    c.fill();
  };
  c.fillStyle = palette[ink];
  canvas.pen(ink, 1, dash);
  area(least, most, FAINT);
  area(low, high, SHADE);
  c.globalAlpha = EDGES;
  for (const edge of [low, high]) {
    c.beginPath();
    line(edge);
    c.stroke();
  }
  c.globalAlpha = 1;
}
