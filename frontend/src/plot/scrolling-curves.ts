/** Curves that grow at one end, as a picture of its own: it moves as time goes on, and gets what is new. */

import { boxOf } from './axes';
import type { AxisScale } from './axis-scale';
import type { Bins } from './bins';
import { Canvas } from './canvas';
import type { SampleSource } from './source';
import type { SourceCurve } from './source-curve';

/** What is cleared before the first new bin, where a line to it begins or may reach, CSS pixels. */
const CLEARED = 2;
/** Where curves go on, so far before what is cleared that no line begins in it, CSS pixels. */
const BEFORE = 3;

/** Curves and the value axis that they share. */
export interface CurveGroup {
  readonly curves: readonly SourceCurve[];
  readonly y: AxisScale;
}

/** Room for the picture to move in, in its own widths. */
const WIDTHS = 2;

/** What was drawn last. */
interface Drawn {
  source: SampleSource;
  revision: number;
  /** First sample that there was, and the one after the last that was read and in the picture. */
  first: number;
  last: number;
  bins: Bins;
  x: AxisScale;
  axes: string;
}

export class ScrollingCurves {
  private readonly layer: Canvas;
  private drawn: Drawn | null = null;
  /** Where on the layer the picture begins, device pixels. */
  private place = 0;

  constructor(private readonly canvas: Canvas) {
    this.layer = new Canvas(document.createElement('canvas'), canvas.palette);
    this.layer.resize(WIDTHS * canvas.width, canvas.height);
  }

  /** The same times to a whole number of pixels, by which a picture can be moved. */
  snapped({ from, to }: { from: number; to: number }, across: number): [number, number] {
    const pixel = (to - from) / (across * devicePixelRatio);
    const begin = Math.round(from / pixel) * pixel;
    return [begin, begin + to - from];
  }

  /** How many of the first bins hold what they did when they were drawn last. */
  kept(source: SampleSource, bins: Bins): number {
    const { drawn } = this;
    const { first, size, count } = bins;
    if (drawn?.source !== source || drawn.revision !== source.revision) return 0;
    if (drawn.bins.size !== size || first < drawn.bins.first) return 0;
    if (source.first !== drawn.first && source.first + size > first) return 0;
    const known = drawn.bins.first + drawn.bins.count * size;
    const until = Math.floor(Math.min(drawn.last, known) / size) * size;
    return Math.min(count, Math.max(0, (until - first) / size));
  }

  /** Draws what the curves have read, of whose bins the first ones were kept. */
  draw(
    source: SampleSource,
    groups: readonly CurveGroup[],
    x: AxisScale,
    bins: Bins,
    kept: number,
  ): void {
    const axes = `${(x.to - x.from).toPrecision(9)} ${x.pixels.join()} ${groups.map(({ y }) => `${y.from} ${y.to}`).join()}`;
    const { layer, canvas } = this;
    const [left, right] = x.pixels;
    const perPixel = (x.to - x.from) / ((right - left) * devicePixelRatio);
    const moved = this.drawn ? (x.from - this.drawn.x.from) / perPixel : 0;
    const box = boxOf(x, (groups[0] as CurveGroup).y);
    const all = (after: number) => {
      for (const { curves, y } of groups) {
        for (const curve of curves) curve.draw(layer, source, x, y, after);
      }
    };
    const perBin = (bins.size * source.step) / perPixel / devicePixelRatio;
    const again = Math.ceil((CLEARED + BEFORE) / perBin) + 2;
    if (axes === this.drawn?.axes && moved > -0.5 && kept > again) {
      this.move(Math.round(moved));
      const begin = x.px(source.start + (bins.first + (kept - 1) * bins.size) * source.step);
      const clear = Math.floor((begin - CLEARED) * devicePixelRatio) / devicePixelRatio;
      const from = Math.max(left, clear);
      layer.c.clearRect(from, 0, layer.width - from, layer.height);
      layer.clipped({ ...box, left: from }, () => all(kept - again));
    } else {
      this.place = 0;
      layer.clear();
      layer.clipped(box, () => all(0));
    }
    canvas.clipped(box, () => {
      canvas.c.resetTransform();
      canvas.c.drawImage(layer.element, -this.place, 0);
    });
    const seen = Math.floor((x.to - source.start) / source.step);
    this.drawn = {
      source,
      revision: source.revision ?? 0,
      first: source.first,
      last: Math.min(source.last, seen),
      bins,
      x,
      axes,
    };
  }

  /** Moves everything so many device pixels to the left: less often than what is looked at. */
  private move(pixels: number): void {
    const { c, element } = this.layer;
    this.place += pixels;
    if (this.place > element.width - this.canvas.element.width) {
      c.resetTransform();
      c.globalCompositeOperation = 'copy';
      c.drawImage(element, -this.place, 0);
      c.globalCompositeOperation = 'source-over';
      this.place = 0;
    }
    c.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, this.place, 0);
  }
}
