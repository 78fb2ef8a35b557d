/**
 * The plane: reference path and both movers, seen from above at equal scales. Errors are a
 * thousandth of the path, so they are magnified: a mover is drawn at reference − factor × error.
 */

import { type Bins, pointsOf, writeCurve } from './bins';
import type { Canvas } from './canvas';
import type { Ink } from './palette';
import { Plane } from './plane';
import { type Range, roundStep } from './range';
import type { SampleSource } from './source';
import type { PathUnderlay } from './run-overlay';
import { looksOf } from './palette';

const MARGIN = 0.04;
/** The largest error is drawn about this long, as a share of the path's size. */
const SHARE = 0.18;
const MARK_SPACING = 70;

interface Extent {
  x: Range;
  y: Range;
}

interface Trail {
  x: Float32Array;
  y: Float32Array;
}

/** Returns a factor of 1, 2 or 5 times a power of ten that makes `error` visible on a path of `size`. */
export function magnification(size: number, error: number): number {
  if (!(error > 0) || !(size > 0)) return 1;
  const factor = (SHARE * size) / error;
  const step = roundStep(factor);
  const below = step > factor * (1 + 1e-9) ? roundStep(step / 2.5) : step;
  return Math.max(1, below);
}

const NOTHING: Trail = { x: new Float32Array(0), y: new Float32Array(0) };

export class PlaneView {
  /** Factor by which errors are drawn larger; 0 before anything is drawn. */
  factor = 0;
  private reference = NOTHING;
  private movers: Trail[] = [];
  private count = 0;
  private box: Extent | null = null;
  private readonly plane: Plane;

  constructor(
    private readonly canvas: Canvas,
    private readonly variants: readonly string[],
  ) {
    this.plane = new Plane(canvas);
  }

  draw(
    source: SampleSource,
    range: Range,
    at: number,
    underlays: readonly PathUnderlay[] = [],
  ): void {
    const { canvas, plane } = this;
    this.read(source, range, underlays);
    canvas.clear();
    if (!this.box) return;
    const { x, y } = this.box;
    plane.centre = [(x.from + x.to) / 2, (y.from + y.to) / 2];
    plane.scale = plane.fitting(x.to - x.from, y.to - y.from);
    plane.grid();
    canvas.clipped(plane.box, () => {
      this.path(this.reference, 'reference', 1);
      for (const each of underlays) each.draw(canvas, plane, this.factor, at);
      this.variants.slice(0, 2).forEach((variant, i) => {
        const mover = this.movers[i] as Trail;
        const { ink = 'text', marker } = looksOf(variant);
        this.path(mover, ink, 1.75);
        if (marker) this.markers(mover, ink);
      });
      this.places(source, at);
    });
  }

  /** Chooses the factor without drawing. */
  measure(source: SampleSource, range: Range): void {
    this.read(source, range, []);
  }

  /** Fills reference and movers; the movers hold errors until the factor is known. */
  private read(source: SampleSource, range: Range, underlays: readonly PathUnderlay[]): void {
    const bins = pathBins(source, range);
    const trail = (prefix: string, channel: string): Trail => ({
      x: pathValues(source, `${prefix}x.${channel}`, bins),
      y: pathValues(source, `${prefix}y.${channel}`, bins),
    });
    this.count = pointsOf(bins);
    this.reference = trail('', 'position_reference');
    this.movers = this.variants
      .slice(0, 2)
      .map((variant) => trail(`${variant}.`, 'following_error'));
    const largest = Math.max(this.largestError(), ...underlays.map((each) => each.read(range)));
    this.chooseBox(this.factor * largest);
    this.chooseFactor(largest);
    for (const mover of this.movers) {
      for (let i = 0; i < this.count; i++) {
        mover.x[i] = (this.reference.x[i] as number) - this.factor * (mover.x[i] as number);
        mover.y[i] = (this.reference.y[i] as number) - this.factor * (mover.y[i] as number);
      }
    }
  }

  private largestError(): number {
    let largest = 0;
    for (const { x, y } of this.movers) {
      for (let i = 0; i < this.count; i++) {
        const error = Math.hypot(x[i] as number, y[i] as number);
        if (error > largest) largest = error;
      }
    }
    return largest;
  }

  /** Chooses what is in view: the reference, and beside it what movers stray, `reach` at most. */
  private chooseBox(reach: number): void {
    const box: Extent = { x: empty(), y: empty() };
    for (let i = 0; i < this.count; i++) {
      widen(box.x, this.reference.x[i] as number);
      widen(box.y, this.reference.y[i] as number);
    }
    if (!(box.x.from <= box.x.to)) return;
    const extent = Math.max(box.x.to - box.x.from, box.y.to - box.y.from, 1e-7);
    const room = (SHARE + MARGIN) * extent;
    const fitted = {
      x: { from: box.x.from - room, to: box.x.to + room },
      y: { from: box.y.from - room, to: box.y.to + room },
    };
    const present = this.box;
    // Calm: the view stays until the path leaves it or has become much smaller.
    const stays =
      present &&
      present.x.from <= box.x.from - reach &&
      present.x.to >= box.x.to + reach &&
      present.y.from <= box.y.from - reach &&
      present.y.to >= box.y.to + reach &&
      extent > 0.4 * Math.max(present.x.to - present.x.from, present.y.to - present.y.from);
    if (!stays) this.box = fitted;
  }

  private chooseFactor(error: number): void {
    if (!this.box) return;
    const { x, y } = this.box;
    const size = Math.max(x.to - x.from, y.to - y.from) / (1 + 2 * (SHARE + MARGIN));
    const factor = magnification(size, error);
    const share = (this.factor * error) / size;
    const stays = share < 1.2 * SHARE && factor < 2 * this.factor;
    if (!stays) this.factor = factor;
  }

  private path({ x, y }: Trail, ink: Ink, width: number): void {
    const { canvas, plane } = this;
    const { c } = canvas;
    canvas.pen(ink, width);
    c.lineJoin = 'bevel';
    c.beginPath();
    canvas.trace(this.count, (i) => [plane.px(x[i] as number), plane.py(y[i] as number)]);
    c.stroke();
  }

  private markers({ x, y }: Trail, ink: Ink): void {
    const { plane } = this;
    let run = 0;
    for (let i = 1; i < this.count; i++) {
      const [px, py] = [plane.px(x[i] as number), plane.py(y[i] as number)];
      const ahead = Math.hypot(
        px - plane.px(x[i - 1] as number),
        py - plane.py(y[i - 1] as number),
      );
      if (!Number.isFinite(ahead)) continue;
      run += ahead;
      if (run < MARK_SPACING) continue;
      run = 0;
      this.canvas.dot(px, py, 2.5, ink);
    }
  }

  /** Where reference and movers are at one moment. */
  private places(source: SampleSource, at: number): void {
    const x = source.at('x.position_reference', at);
    const y = source.at('y.position_reference', at);
    if (!Number.isFinite(x) || !Number.isFinite(y)) return;
    this.dot(x, y, 3.5, 'reference');
    this.variants.slice(0, 2).forEach((variant) => {
      const ex = source.at(`${variant}.x.following_error`, at);
      const ey = source.at(`${variant}.y.following_error`, at);
      if (!Number.isFinite(ex) || !Number.isFinite(ey)) return;
      this.dot(x - this.factor * ex, y - this.factor * ey, 5, looksOf(variant).ink ?? 'text');
    });
  }

  private dot(x: number, y: number, radius: number, ink: Ink): void {
    const { canvas, plane } = this;
    canvas.dot(plane.px(x), plane.py(y), radius, ink);
    canvas.pen('panel', 1.5);
    canvas.c.stroke();
  }
}

function empty(): Range {
  return { from: Number.POSITIVE_INFINITY, to: Number.NEGATIVE_INFINITY };
}

function widen(range: Range, value: number): void {
  if (value < range.from) range.from = value;
  if (value > range.to) range.to = value;
}

const LEAST = 1000;
const MOST = 8000;
/** Longest bin while there are not too many of them, s. */
const FINE = 6e-3;

/** Cuts a stretch of time into the bins of a path: finer than its corners, whatever its length. */
export function pathBins(source: SampleSource, { from, to }: Range): Bins {
  const bins = Math.min(MOST, Math.max(LEAST, Math.ceil((to - from) / FINE)));
  return source.cut(from, to, bins);
}

/** Reads a column, two values for each bin that has several samples. */
export function pathValues(source: SampleSource, column: string, bins: Bins): Float32Array {
  const [low, high] = [new Float32Array(bins.count), new Float32Array(bins.count)];
  source.reduce(column, bins, low, high);
  const values = new Float32Array(pointsOf(bins));
  writeCurve(bins, low, high, values);
  return values;
}
