/** What all canvases share: sharp pixels, the page's font and colours, clipping, dots. */

import type { Palette } from './palette';

/** Edges of the part that is drawn in, CSS pixels. */
export interface Box {
  left: number;
  right: number;
  top: number;
  bottom: number;
}

export class Canvas {
  readonly c: CanvasRenderingContext2D;
  /** CSS pixels. */
  width = 1;
  height = 1;
  private readonly family: string;

  constructor(
    readonly element: HTMLCanvasElement,
    readonly palette: Palette,
  ) {
    this.c = element.getContext('2d') as CanvasRenderingContext2D;
    this.family = getComputedStyle(element).fontFamily;
  }

  resize(width: number, height: number): void {
    [this.width, this.height] = [Math.max(1, width), Math.max(1, height)];
    this.element.width = Math.round(this.width * devicePixelRatio);
    this.element.height = Math.round(this.height * devicePixelRatio);
  }

  clear(): void {
    this.c.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
    this.c.clearRect(0, 0, this.width, this.height);
  }

  font(size = 11, weight = 400): void {
    this.c.font = `${weight} ${size}px ${this.family}`;
  }

  /** Draws what stays within a box. */
  clipped({ left, right, top, bottom }: Box, draw: () => void): void {
    const { c } = this;
    c.save();
    c.beginPath();
    c.rect(left, top, right - left, bottom - top);
    c.clip();
    draw();
    c.restore();
  }

  /** A straight line, sharp where it is upright or level. */
  line(from: readonly [number, number], to: readonly [number, number], colour: string): void {
    const { c } = this;
    c.strokeStyle = colour;
    c.beginPath();
    c.moveTo(...from);
    c.lineTo(...to);
    c.stroke();
  }

  /** A line through points; where a coordinate is none, it has a gap. */
  trace(count: number, at: (i: number) => readonly [number, number], first = 0): void {
    const { c } = this;
    let pen = false;
    for (let i = first; i < count; i++) {
      const [x, y] = at(i);
      if (x !== x || y !== y) pen = false;
      else if (pen) c.lineTo(x, y);
      else {
        c.moveTo(x, y);
        pen = true;
      }
    }
  }

  dot(x: number, y: number, radius: number, colour: string): void {
    const { c } = this;
    c.beginPath();
    c.arc(x, y, radius, 0, 2 * Math.PI);
    c.fillStyle = colour;
    c.fill();
  }
}

/** Pixel of a line one pixel wide. */
export function crisp(px: number): number {
  return Math.round(px) + 0.5;
}

/** Returns a pattern of slanted lines, so that what it marks does not depend on colour. */
export function hatching(context: CanvasRenderingContext2D, colour: string): CanvasPattern | null {
  const side = 6 * devicePixelRatio;
  const tile = document.createElement('canvas');
  tile.width = tile.height = side;
  const c = tile.getContext('2d');
  if (!c) return null;
  c.strokeStyle = colour;
  c.lineWidth = 1.6 * devicePixelRatio;
  c.beginPath();
  for (const shift of [-side, 0, side]) {
    c.moveTo(shift - 1, side + 1);
    c.lineTo(shift + side + 1, -1);
  }
  c.stroke();
  const pattern = context.createPattern(tile, 'repeat');
  pattern?.setTransform(new DOMMatrix().scale(1 / devicePixelRatio));
  return pattern;
}
