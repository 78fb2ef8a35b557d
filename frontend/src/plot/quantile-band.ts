/** Bands behind the curves of a scope: how one quantity is spread over many runs. */

import type { Ink } from './palette';
import type { Range } from './range';

export interface QuantileBand {
  ink: Ink;
  /** Lengths of dash and gap of the edges: what tells B from A without colour. */
  dash: number[];
  time: readonly number[];
  least: readonly number[];
  low: readonly number[];
  high: readonly number[];
  most: readonly number[];
}

const FAINT = 0.1;
const SHADE = 0.2;
const EDGES = 0.5;

/** Returns the least and the largest value over a range of time. */
export function bandExtremes({ time, least, most }: QuantileBand, { from, to }: Range) {
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
export function drawQuantileBand(
  c: CanvasRenderingContext2D,
  { dash, time, least, low, high, most }: QuantileBand,
  colour: string,
  x: (time: number) => number,
  y: (value: number) => number,
): void {
  const line = (values: readonly number[], back = false) => {
    for (let i = 0; i < time.length; i++) {
      const k = back ? time.length - 1 - i : i;
      c.lineTo(x(time[k] as number), y(values[k] as number));
    }
  };
  const area = (bottom: readonly number[], top: readonly number[], alpha: number) => {
    c.globalAlpha = alpha;
    c.beginPath();
    line(bottom);
    line(top, true);
    c.fill();
  };
  c.fillStyle = colour;
  c.strokeStyle = colour;
  c.lineWidth = 1;
  c.setLineDash(dash);
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
