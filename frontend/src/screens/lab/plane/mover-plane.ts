/**
 * The plane: reference path and both movers, seen from above at equal scales. Errors are a
 * thousandth of the path, so they are magnified: a mover is drawn at reference − factor × error.
 */

import type { Palette } from '../../../plot/palette';
import { multiples, roundStep, type Range } from '../../../plot/range';
import type { Source } from '../../../plot/source';
import { minus, scaleFor } from '../../../ui/units';

const POINTS = 1000;
const MARGIN = 0.04;
/** The largest error is drawn about this long, as a share of the path's size. */
const SHARE = 0.18;
/** Room for the labels of the axes, CSS pixels. */
const LEFT = 58;
const RIGHT = 14;
const BOTTOM = 20;
const EDGE = 6;
const MARK_SPACING = 70;

export interface Size {
  width: number;
  height: number;
}

interface Box {
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
  const wanted = (SHARE * size) / error;
  const step = roundStep(wanted);
  const below = step > wanted * (1 + 1e-9) ? roundStep(step / 2.5) : step;
  return Math.max(1, below);
}

function trail(length: number): Trail {
  return { x: new Float32Array(length), y: new Float32Array(length) };
}

export class PlaneView {
  /** Factor by which errors are drawn larger; 0 before anything is drawn. */
  factor = 0;
  private readonly reference = trail(POINTS + 2);
  private readonly movers: Trail[] = [trail(POINTS + 2), trail(POINTS + 2)];
  private readonly low = new Float32Array(POINTS + 2);
  private readonly high = new Float32Array(POINTS + 2);
  private count = 0;
  private box: Box | null = null;
  private scale = 1;
  private size: Size = { width: 1, height: 1 };
  private readonly family: string;

  constructor(
    private readonly context: CanvasRenderingContext2D,
    private readonly variants: readonly string[],
    private readonly palette: Palette,
  ) {
    this.family = getComputedStyle(context.canvas).fontFamily;
  }

  draw(source: Source, range: Range, at: number, size: Size): void {
    this.size = size;
    this.read(source, range);
    this.frame();
    const { context: c } = this;
    c.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
    c.clearRect(0, 0, size.width, size.height);
    this.grid();
    // What is drawn stays between the axes.
    c.save();
    c.beginPath();
    c.rect(LEFT, 0, size.width - LEFT - RIGHT, size.height - BOTTOM);
    c.clip();
    this.path(this.reference, this.palette.reference, 1);
    const inks = [this.palette.a, this.palette.b];
    this.variants.slice(0, 2).forEach((_, i) => {
      const mover = this.movers[i] as Trail;
      this.path(mover, inks[i] as string, 1.75);
      if (i === 1) this.markers(mover, inks[i] as string);
    });
    this.places(source, at, inks);
    c.restore();
  }

  /** Fills reference and movers; the movers hold errors until the factor is known. */
  private read(source: Source, range: Range): void {
    const bins = source.cut(range.from, range.to, POINTS);
    this.count = Math.min(bins.count, POINTS + 2);
    const middle = (column: string, target: Float32Array) => {
      source.reduce(column, { ...bins, count: this.count }, this.low, this.high);
      for (let i = 0; i < this.count; i++) {
        target[i] = ((this.low[i] as number) + (this.high[i] as number)) / 2;
      }
    };
    middle('x.position_reference', this.reference.x);
    middle('y.position_reference', this.reference.y);
    this.variants.slice(0, 2).forEach((variant, i) => {
      middle(`${variant}.x.following_error`, (this.movers[i] as Trail).x);
      middle(`${variant}.y.following_error`, (this.movers[i] as Trail).y);
    });
    const largest = this.largestError();
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
    this.variants.slice(0, 2).forEach((_, v) => {
      const { x, y } = this.movers[v] as Trail;
      for (let i = 0; i < this.count; i++) {
        const error = Math.hypot(x[i] as number, y[i] as number);
        if (error > largest) largest = error;
      }
    });
    return largest;
  }

  /** Chooses what is in view: the reference, and beside it what movers stray, `reach` at most. */
  private chooseBox(reach: number): void {
    const box: Box = { x: empty(), y: empty() };
    for (let i = 0; i < this.count; i++) {
      widen(box.x, this.reference.x[i] as number);
      widen(box.y, this.reference.y[i] as number);
    }
    if (!(box.x.from <= box.x.to)) return;
    const extent = Math.max(box.x.to - box.x.from, box.y.to - box.y.from, 1e-7);
    const room = (SHARE + MARGIN) * extent;
    const wanted = {
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
    if (!stays) this.box = wanted;
  }

  private chooseFactor(error: number): void {
    if (!this.box) return;
    const { x, y } = this.box;
    const size = Math.max(x.to - x.from, y.to - y.from) / (1 + 2 * (SHARE + MARGIN));
    const wanted = magnification(size, error);
    const share = (this.factor * error) / size;
    const stays = share < 1.2 * SHARE && wanted < 2 * this.factor;
    if (!stays) this.factor = wanted;
  }

  /** Chooses pixels per metre so that the box fits beside the labels, equal on both axes. */
  private frame(): void {
    if (!this.box) return;
    const { x, y } = this.box;
    this.scale = Math.min(
      (this.size.width - LEFT - RIGHT) / Math.max(1e-9, x.to - x.from),
      (this.size.height - BOTTOM - EDGE) / Math.max(1e-9, y.to - y.from),
    );
  }

  private px(x: number): number {
    const box = this.box?.x ?? { from: -1, to: 1 };
    return (this.size.width + LEFT - RIGHT) / 2 + (x - (box.from + box.to) / 2) * this.scale;
  }

  private py(y: number): number {
    const box = this.box?.y ?? { from: -1, to: 1 };
    return (this.size.height - BOTTOM + EDGE) / 2 - (y - (box.from + box.to) / 2) * this.scale;
  }

  /** Returns the places that a stretch of pixels shows. */
  private visible(): Box {
    const { width, height } = this.size;
    const at = { x: this.px(0), y: this.py(0) };
    return {
      x: { from: (LEFT - at.x) / this.scale, to: (width - RIGHT - at.x) / this.scale },
      y: { from: (at.y - height + BOTTOM) / this.scale, to: at.y / this.scale },
    };
  }

  private grid(): void {
    if (!this.box) return;
    const { context: c, palette, size } = this;
    const { x: columns, y: rows } = this.visible();
    const step = roundStep(48 / this.scale);
    const { factor, unit } = scaleFor(Math.max(step * 2, Math.abs(rows.to)), 'm');
    const places = Math.max(0, Math.ceil(-Math.log10(step * factor) - 1e-9));
    const text = (value: number) => minus((value * factor).toFixed(places));
    c.strokeStyle = palette.grid;
    c.fillStyle = palette.axis;
    c.lineWidth = 1;
    c.font = `11px ${this.family}`;
    c.textBaseline = 'middle';
    c.textAlign = 'right';
    c.beginPath();
    const levels = multiples(rows, step).filter((y) => this.py(y) > 8);
    levels.forEach((y, i) => {
      const at = Math.round(this.py(y)) + 0.5;
      c.moveTo(LEFT, at);
      c.lineTo(size.width - RIGHT, at);
      c.fillText(i === levels.length - 1 ? `${text(y)} ${unit}` : text(y), LEFT - 6, at);
    });
    c.textAlign = 'center';
    const marks = multiples(columns, step);
    const fits = (x: number) => this.px(x) > LEFT + 8 && this.px(x) < size.width - 24;
    const last = marks.filter(fits).at(-1);
    for (const x of marks) {
      const at = Math.round(this.px(x)) + 0.5;
      c.moveTo(at, 0);
      c.lineTo(at, size.height - BOTTOM);
      if (fits(x)) c.fillText(x === last ? `${text(x)} ${unit}` : text(x), at, size.height - 8);
    }
    c.stroke();
  }

  private path({ x, y }: Trail, colour: string, width: number): void {
    const { context: c } = this;
    c.strokeStyle = colour;
    c.lineWidth = width;
    c.lineJoin = 'bevel';
    c.beginPath();
    let pen = false;
    for (let i = 0; i < this.count; i++) {
      const [px, py] = [this.px(x[i] as number), this.py(y[i] as number)];
      if (px !== px || py !== py) {
        pen = false;
      } else if (pen) {
        c.lineTo(px, py);
      } else {
        c.moveTo(px, py);
        pen = true;
      }
    }
    c.stroke();
  }

  private markers({ x, y }: Trail, colour: string): void {
    const { context: c } = this;
    c.fillStyle = colour;
    let run = 0;
    for (let i = 1; i < this.count; i++) {
      const [px, py] = [this.px(x[i] as number), this.py(y[i] as number)];
      const ahead = Math.hypot(px - this.px(x[i - 1] as number), py - this.py(y[i - 1] as number));
      if (!Number.isFinite(ahead)) continue;
      run += ahead;
      if (run < MARK_SPACING) continue;
      run = 0;
      c.beginPath();
      c.arc(px, py, 2.5, 0, 2 * Math.PI);
      c.fill();
    }
  }

  /** Where reference and movers are at one moment. */
  private places(source: Source, at: number, inks: readonly string[]): void {
    const x = source.at('x.position_reference', at);
    const y = source.at('y.position_reference', at);
    if (!Number.isFinite(x) || !Number.isFinite(y)) return;
    this.dot(x, y, 3.5, this.palette.reference);
    this.variants.slice(0, 2).forEach((variant, i) => {
      const ex = source.at(`${variant}.x.following_error`, at);
      const ey = source.at(`${variant}.y.following_error`, at);
      if (!Number.isFinite(ex) || !Number.isFinite(ey)) return;
      this.dot(x - this.factor * ex, y - this.factor * ey, 5, inks[i] as string);
    });
  }

  private dot(x: number, y: number, radius: number, colour: string): void {
    const { context: c } = this;
    c.beginPath();
    c.arc(this.px(x), this.py(y), radius, 0, 2 * Math.PI);
    c.fillStyle = colour;
    c.fill();
    c.lineWidth = 1.5;
    c.strokeStyle = this.palette.panel;
    c.stroke();
  }
}

function empty(): Range {
  return { from: Number.POSITIVE_INFINITY, to: Number.NEGATIVE_INFINITY };
}

function widen(range: Range, value: number): void {
  if (value < range.from) range.from = value;
  if (value > range.to) range.to = value;
}
