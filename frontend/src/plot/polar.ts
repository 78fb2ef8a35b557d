/** Deviations over an angle, on rings about a circle of zero deviation. */

import { scaleFor } from '../ui/units';
import type { Canvas } from './canvas';
import type { Look } from './types';

export interface PolarCurve extends Look {
  name: string;
  /** Deviation at equal angles, half a step behind 0 the first; SI. */
  values: readonly number[];
}

/** Of the shorter half of the canvas: the ring of the least deviation, and that of the largest. */
const INNER = 0.38;
/** Room for the angles beside and above it, and between the numbers of two rings, CSS pixels. */
const SIDE = 34;
const LETTERS = 18;
const LINE = 12;
const RINGS = 4;
const MARKER_EVERY = 30; // degrees

/** Draws the curves; returns how much larger deviations are drawn than a circle of this radius, m. */
export function drawPolar(canvas: Canvas, curves: readonly PolarCurve[], radius: number): number {
  const { c, width, height } = canvas;
  canvas.clear();
  const all = curves.flatMap(({ values }) => values);
  if (all.length === 0) return 0;
  const step = niceStep((Math.max(0, ...all) - Math.min(0, ...all)) / RINGS);
  const low = Math.floor(Math.min(0, ...all) / step) * step;
  const high = Math.max(step, Math.ceil(Math.max(0, ...all) / step) * step);
  const half = Math.max(1, Math.min(width / 2 - SIDE, height / 2 - LETTERS));
  const [x0, y0] = [width / 2, height / 2];
  const perMetre = ((1 - INNER) * half) / (high - low);
  const ring = (value: number) => INNER * half + (value - low) * perMetre;
  const { factor, unit } = scaleFor(step, 'm');

  canvas.pen('grid');
  const out = ring(high);
  canvas.lines([
    [x0 - out, y0, x0 + out, y0],
    [x0, y0 - out, x0, y0 + out],
  ]);
  canvas.font();
  for (let k = Math.round(low / step); k <= Math.round(high / step); k++) {
    canvas.pen(k === 0 ? 'reference' : 'grid', k === 0 ? 1.5 : 1);
    c.beginPath();
    c.arc(x0, y0, ring(k * step), 0, 2 * Math.PI);
    c.stroke();
  }
  for (const { values, ink = 'a', dash = 'solid', marker, width: line = 1.5 } of curves) {
    const at = (i: number): [number, number] => {
      const angle = (((i % values.length) + 0.5) / values.length) * 2 * Math.PI;
      const away = ring(values[i % values.length] as number);
      return [x0 + away * Math.cos(angle), y0 - away * Math.sin(angle)];
    };
    canvas.pen(ink, line, dash);
    c.beginPath();
    canvas.trace(values.length + 1, at);
    c.stroke();
    if (!marker) continue;
    const every = Math.round((values.length * MARKER_EVERY) / 360);
    for (let i = Math.round(every / 2); i < values.length; i += every) {
      const [x, y] = at(i);
      canvas.dot(x, y, 2.5, ink);
    }
  }
  const rim = canvas.palette.panel;
  const last = Math.round(high / step);
  const every = Math.max(1, Math.ceil(LINE / (step * perMetre * Math.SQRT1_2)));
  for (let k = last; k >= Math.round(low / step); k -= every) {
    const shown = Number((k * step * factor).toPrecision(3))
      .toString()
      .replace('-', '−');
    const text = k > 0 ? `+${shown}` : shown;
    const label = k === last ? `${text} ${unit}` : text;
    const away = ring(k * step) * Math.SQRT1_2;
    canvas.write(label, x0 + away, y0 - away, { ink: 'muted', rim, align: 'center' });
  }
  const edge = out + 4;
  canvas.write('0°', x0 + edge, y0, { ink: 'muted' });
  canvas.write('90°', x0, y0 - edge, { ink: 'muted', align: 'center', baseline: 'bottom' });
  canvas.write('180°', x0 - edge, y0, { ink: 'muted', align: 'right' });
  canvas.write('270°', x0, y0 + edge, { ink: 'muted', align: 'center', baseline: 'top' });
  return (perMetre * radius) / ring(0);
}

/** The distance of rings: 1, 2 or 5 times a power of ten, no less than asked for. */
export function niceStep(least: number): number {
  if (!(least > 0)) return 1e-9;
  const power = 10 ** Math.floor(Math.log10(least) + 1e-9);
  const step = [1, 2, 5, 10].find((each) => each * power >= least * (1 - 1e-9)) ?? 10;
  return step * power;
}
