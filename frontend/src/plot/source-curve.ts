/** A curve of a source over time: cut into as many bins as the axis has pixels, then drawn. */

import type { AxisScale } from './axis-scale';
import { pointsOf, writeCurve, type Bins } from './bins';
import { patternOf, type Canvas } from './canvas';
import type { SampleSource } from './source';
import type { Look } from './types';

/** A curve that goes up and down this many times its width is dense. */
const DENSE = 6;

export class SourceCurve {
  private values = new Float32Array(0);
  private minimum = new Float32Array(0);
  private maximum = new Float32Array(0);
  /** Where in the pattern of its dashes each point is, px. */
  private dashed = new Float32Array(0);
  private dense = false;
  private bins: Bins = { first: 0, size: 1, count: 0, paired: false };

  constructor(
    readonly column: string,
    readonly look: Look,
  ) {}

  /**
   * Reads what some bins hold; returns the least and the largest value.
   *
   * @param kept how many of the first bins hold what they did when they were read last
   */
  read(source: SampleSource, bins: Bins, kept = 0): [number, number] {
    const { first, size, count } = bins;
    const per = pointsOf(bins) / count;
    if (this.minimum.length < count) {
      this.minimum = grown(this.minimum, count);
      this.maximum = grown(this.maximum, count);
      this.values = grown(this.values, 2 * count);
      this.dashed = grown(this.dashed, 2 * count);
    }
    const { minimum, maximum, values, dashed } = this;
    const gone = kept > 0 ? (first - this.bins.first) / size : 0;
    if (gone > 0) {
      for (const each of [minimum, maximum]) each.copyWithin(0, gone, gone + kept);
      for (const each of [values, dashed]) each.copyWithin(0, per * gone, per * (gone + kept));
    }
    this.bins = bins;
    const fresh = { ...bins, first: first + kept * size, count: count - kept };
    source.reduce(this.column, fresh, minimum.subarray(kept), maximum.subarray(kept));
    writeCurve(bins, minimum, maximum, values, kept);
    let low = Number.POSITIVE_INFINITY;
    let high = Number.NEGATIVE_INFINITY;
    for (let bin = 0; bin < count; bin++) {
      if ((minimum[bin] as number) < low) low = minimum[bin] as number;
      if ((maximum[bin] as number) > high) high = maximum[bin] as number;
    }
    return [low, high];
  }

  /**
   * Without dashes where the curve is so dense that they could not be seen: a third of the time.
   *
   * @param after bins that are drawn already; what follows goes on from there
   */
  draw(canvas: Canvas, source: SampleSource, x: AxisScale, y: AxisScale, after = 0): void {
    const { bins, values, dashed } = this;
    const { ink = 'text', width = 1.5, dash } = this.look;
    const { c } = canvas;
    const points = pointsOf(bins);
    const start = x.px(source.start + bins.first * source.step);
    const end = x.px(source.start + (bins.first + bins.count * bins.size) * source.step);
    const apart = (end - start) / points;
    const [foot, perUnit] = [y.px(0), y.px(1) - y.px(0)];
    const begin = (points / bins.count) * after;
    const pattern = patternOf(dash ?? 'solid');
    const offset = pattern > 0 && begin > 0 ? (dashed[begin] as number) : 0;
    let pen = false;
    let travelled = 0;
    let before = 0;
    let length = offset;
    c.beginPath();
    for (let k = begin; k < points; k++) {
      const py = foot + (values[k] as number) * perUnit;
      if (py !== py) {
        pen = false;
        continue;
      }
      const px = start + k * apart;
      if (pen) {
        c.lineTo(px, py);
        travelled += Math.abs(py - before);
        if (pattern > 0) length += Math.hypot(apart, py - before);
      } else {
        c.moveTo(px, py);
        pen = true;
      }
      before = py;
      if (pattern > 0) dashed[k] = length %= pattern;
    }
    if (begin === 0) this.dense = travelled > DENSE * (x.pixels[1] - x.pixels[0]);
    const { dense } = this;
    // Where its dashes leave nothing of them to be seen, it goes below the two that it compares.
    c.globalCompositeOperation = dense && ink === 'difference' ? 'destination-over' : 'source-over';
    canvas.pen(ink, dense ? 1 : width, dense ? 'solid' : dash);
    c.lineJoin = 'bevel';
    c.lineDashOffset = offset;
    c.stroke();
    c.lineDashOffset = 0;
    c.globalCompositeOperation = 'source-over';
  }
}

function grown(values: Float32Array, count: number): Float32Array<ArrayBuffer> {
  const made = new Float32Array(count + 64);
  made.set(values);
  return made;
}
