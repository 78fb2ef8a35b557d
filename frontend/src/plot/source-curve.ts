/** A curve of a source over time: cut into as many bins as the axis has pixels, then drawn. */

import type { AxisScale } from './axis-scale';
import { pointsOf, writeCurve, type Bins } from './bins';
import type { Canvas } from './canvas';
import type { SampleSource } from './source';
import type { Look } from './types';

/** A curve that goes up and down this many times its width is dense. */
const DENSE = 6;

let minimum = new Float32Array(0);
let maximum = new Float32Array(0);

export class SourceCurve {
  private values = new Float32Array(0);
  private bins: Bins = { first: 0, size: 1, count: 0, paired: false };

  constructor(
    readonly column: string,
    readonly look: Look,
  ) {}

  /** Reads what some bins hold; returns the least and the largest value. */
  read(source: SampleSource, bins: Bins): [number, number] {
    const { count } = (this.bins = bins);
    if (minimum.length < count) {
      minimum = new Float32Array(count + 64);
      maximum = new Float32Array(count + 64);
    }
    source.reduce(this.column, bins, minimum, maximum);
    if (this.values.length < pointsOf(bins)) this.values = new Float32Array(pointsOf(bins) + 128);
    writeCurve(bins, minimum, maximum, this.values);
    let low = Number.POSITIVE_INFINITY;
    let high = Number.NEGATIVE_INFINITY;
    for (let bin = 0; bin < count; bin++) {
      if ((minimum[bin] as number) < low) low = minimum[bin] as number;
      if ((maximum[bin] as number) > high) high = maximum[bin] as number;
    }
    return [low, high];
  }

  /** Without dashes where the curve is so dense that they could not be seen: a third of the time. */
  draw(canvas: Canvas, source: SampleSource, x: AxisScale, y: AxisScale): void {
    const { bins, values } = this;
    const { ink = 'text', width = 1.5, dash } = this.look;
    const { c } = canvas;
    const points = pointsOf(bins);
    const start = x.px(source.start + bins.first * source.step);
    const end = x.px(source.start + (bins.first + bins.count * bins.size) * source.step);
    const apart = (end - start) / points;
    const [foot, perUnit] = [y.px(0), y.px(1) - y.px(0)];
    let pen = false;
    let travelled = 0;
    let before = 0;
    c.beginPath();
    for (let k = 0; k < points; k++) {
      const py = foot + (values[k] as number) * perUnit;
      if (py !== py) {
        pen = false;
        continue;
      }
      const px = start + k * apart;
      if (pen) {
        c.lineTo(px, py);
        travelled += Math.abs(py - before);
      } else {
        c.moveTo(px, py);
        pen = true;
      }
      before = py;
    }
    const dense = travelled > DENSE * (x.pixels[1] - x.pixels[0]);
    // Where its dashes leave nothing of them to be seen, it goes below the two that it compares.
    c.globalCompositeOperation = dense && ink === 'difference' ? 'destination-over' : 'source-over';
    canvas.pen(ink, dense ? 1 : width, dense ? 'solid' : dash);
    c.lineJoin = 'bevel';
    c.stroke();
    c.globalCompositeOperation = 'source-over';
  }
}
