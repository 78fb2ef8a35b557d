/** The layer that all plots are drawn on: sharp pixels, colours of the theme, lines, texts, hatching. */

import { loop } from '../ui/animation-loop';
import type { Ink, Palette } from './palette';
import { DASHES, type Dash, type Marker } from './types';

/** Edges of the part that is drawn in, CSS pixels. */
export interface Box {
  left: number;
  right: number;
  top: number;
  bottom: number;
}

export type Segment = readonly [x: number, y: number, toX: number, toY: number];

const SHAPES: Record<Marker, (r: number) => string> = {
  dot: (r) => `m${-r} 0a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0z`,
  circle: (r) => SHAPES.dot(r),
  square: (r) => `m${-r} ${-r}h${2 * r}v${2 * r}h${-2 * r}z`,
  triangle: (r) => `m0 ${-1.2 * r}l${1.2 * r} ${2 * r}h${-2.4 * r}z`,
  diamond: (r) =>
    `m0 ${-1.3 * r}l${1.3 * r} ${1.3 * r}l${-1.3 * r} ${1.3 * r}l${-1.3 * r} ${-1.3 * r}z`,
  cross: (r) => `m${-r} ${-r}l${2 * r} ${2 * r}m0 ${-2 * r}l${-2 * r} ${2 * r}`,
  plus: (r) => `m${-r} 0h${2 * r}m${-r} ${-r}v${2 * r}`,
};

/** Length after which a line of dashes repeats itself, px; 0 for a solid one. */
export function patternOf(dash: Dash): number {
  return DASHES[dash].reduce((sum: number, each) => sum + each, 0);
}

/** The path of one marker, as svg and canvas take it. */
export function markerAt(marker: Marker, px: number, py: number, radius = 3): string {
  return `M${px.toFixed(1)} ${py.toFixed(1)}${SHAPES[marker](radius)}`;
}

/** Pixel of a line one pixel wide. */
export function crisp(px: number): number {
  return Math.round(px) + 0.5;
}

export class Canvas {
  readonly c: CanvasRenderingContext2D;
  /** Whether no other plot beneath has the time axis. */
  readonly alone: boolean = false;
  /** CSS pixels. */
  width = 1;
  height = 1;
  private readonly family: string;
  private readonly hatches = new Map<string, CanvasPattern | string>();

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
    this.hatches.clear();
  }

  clear(): void {
    loop.stir();
    this.c.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
    this.c.clearRect(0, 0, this.width, this.height);
  }

  font(size = 11, weight = 400): void {
    this.c.font = `${weight} ${size}px ${this.family}`;
  }

  /** Chooses how the next lines look. */
  pen(ink: Ink, width = 1, dash: Dash = 'solid'): void {
    this.c.strokeStyle = this.palette[ink];
    this.c.lineWidth = width;
    this.c.setLineDash(DASHES[dash]);
  }

  write(
    text: string,
    x: number,
    y: number,
    { align = 'left', baseline = 'middle', ink, rim }: Partial<Lettering> = {},
  ): void {
    const { c } = this;
    c.textAlign = align;
    c.textBaseline = baseline;
    if (rim !== undefined) {
      c.lineWidth = 3;
      c.lineJoin = 'round';
      c.setLineDash([]);
      c.strokeStyle = rim;
      c.strokeText(text, x, y);
    }
    if (ink) c.fillStyle = this.palette[ink];
    c.fillText(text, x, y);
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

  /** Straight lines with the pen as it is. */
  lines(segments: readonly Segment[]): void {
    const { c } = this;
    c.beginPath();
    for (const [x, y, toX, toY] of segments) {
      c.moveTo(x, y);
      c.lineTo(toX, toY);
    }
    c.stroke();
  }

  /** A path as svg has it, such as markers. */
  shape(path: string): Path2D {
    return new Path2D(path);
  }

  /** A path through points; where a coordinate is none, it has a gap. */
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

  dot(x: number, y: number, radius: number, ink: Ink): void {
    const { c } = this;
    c.beginPath();
    c.arc(x, y, radius, 0, 2 * Math.PI);
    c.fillStyle = this.palette[ink];
    c.fill();
  }

  /** A pattern of slanted lines, so that what it marks does not depend on colour. */
  hatch(ink: Ink, width = 1.6): CanvasPattern | string {
    const key = `${ink} ${width}`;
    const known = this.hatches.get(key);
    if (known !== undefined) return known;
    const made = hatching(this.c, this.palette[ink], width) ?? this.palette[ink];
    this.hatches.set(key, made);
    return made;
  }
}

interface Lettering {
  align: CanvasTextAlign;
  baseline: CanvasTextBaseline;
  ink: Ink;
  /** Colour around the letters, so that they can be read over curves. */
  rim: string;
}

function hatching(context: CanvasRenderingContext2D, colour: string, width: number) {
  const side = 6 * devicePixelRatio;
  const tile = document.createElement('canvas');
  tile.width = tile.height = side;
  const c = tile.getContext('2d');
  if (!c) return null;
  c.strokeStyle = colour;
  c.lineWidth = width * devicePixelRatio;
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
