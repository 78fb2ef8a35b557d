/** The stroke from above at equal scales: grid, path, points, and what is infeasible on it. */

import type { Canvas } from '../../plot/canvas';
import { Plane } from '../../plot/plane';
import { outside, type DrawnPath, type Point } from './drawn-path';
import { stretches, type Checked } from './feasibility';
import { polygon, thinned, type Outline } from './geometry';

/** Numbered places of the worst violations. */
const NUMBERED = 8;
/** Places nearer than this share the first number, CSS pixels. */
const APART = 20;
/** Corners of the curve nearer to the one before than that are left out, CSS pixels. */
const NEAR = 0.75;
/** More points than this are drawn small. */
const MANY = 60;
const ZOOM = { least: 0.7, most: 2000 };

export interface Scene {
  path: DrawnPath | null;
  /** The curve of the path; null while there is none. */
  outline: Outline | null;
  chosen: ReadonlySet<number>;
  checked: Checked | null;
  /** Whether `found` is of the path as it stands; else it is drawn paler. */
  fresh: boolean;
  cursor: number | null;
  stroke: Point;
  /** Whether the curve is drawn without its points. */
  bare?: boolean;
  /** Two corners of the box in which points are being chosen. */
  band?: readonly [Point, Point] | null;
  /** What a hand is drawing. */
  sketch?: readonly Point[] | null;
}

export class PathView {
  private stroke: Point = [0.085, 0.145];
  private zoom = 1;
  private readonly plane: Plane;
  /** Pictures of a point by its size. */
  private readonly dots = new Map<number, ImageBitmap>();

  constructor(private readonly canvas: Canvas) {
    this.plane = new Plane(canvas);
  }

  /** CSS pixels per metre. */
  get scale(): number {
    const whole = this.plane.fitting(2.1 * this.stroke[0], 2.1 * this.stroke[1]);
    return Math.max(1, whole) * this.zoom;
  }

  /** Keeps zoom and centre when the view is made anew, for another theme or size. */
  like(other: PathView | null): this {
    if (other) [this.zoom, this.plane.centre] = [other.zoom, other.plane.centre];
    this.plane.scale = this.scale;
    return this;
  }

  /** Returns which place is at some pixels. */
  place(pixels: Point): Point {
    this.plane.scale = this.scale;
    return this.plane.place(pixels);
  }

  /** Zooms about a place under the pointer, which stays there. */
  zoomAt(pixels: Point, factor: number): void {
    const before = this.place(pixels);
    this.zoom = Math.min(ZOOM.most, Math.max(ZOOM.least, this.zoom * factor));
    const after = this.place(pixels);
    this.pan([before[0] - after[0], before[1] - after[1]]);
  }

  pan([dx, dy]: Point): void {
    const [x, y] = this.plane.centre;
    this.plane.centre = [x + dx, y + dy];
  }

  /** Shows the whole stroke, or all of some points. */
  fit(points: readonly Point[] = []): void {
    [this.zoom, this.plane.centre] = [1, [0, 0]];
    if (points.length < 2) return;
    const [xs, ys] = [points.map(([x]) => x), points.map(([, y]) => y)];
    const [west, east] = [Math.min(...xs), Math.max(...xs)];
    const [south, north] = [Math.min(...ys), Math.max(...ys)];
    this.plane.centre = [(west + east) / 2, (south + north) / 2];
    const fitting = this.plane.fitting(1.3 * (east - west), 1.3 * (north - south));
    this.zoom = Math.min(ZOOM.most, Math.max(ZOOM.least, fitting / this.scale));
  }

  draw(scene: Scene): void {
    const { canvas, plane } = this;
    const { c, palette } = canvas;
    this.stroke = scene.stroke;
    plane.scale = this.scale;
    canvas.clear();
    // The stroke, lighter than what lies beyond.
    const { left, right, top, bottom } = plane.box;
    const [west, north] = this.at([-this.stroke[0], this.stroke[1]]);
    const [east, south] = this.at([this.stroke[0], -this.stroke[1]]);
    c.fillStyle = palette.well;
    c.fillRect(left, top, right - left, bottom - top);
    c.fillStyle = palette.panel;
    canvas.clipped(plane.box, () => c.fillRect(west, north, east - west, south - north));
    plane.grid();
    canvas.clipped(plane.box, () => {
      canvas.pen('strong', 1.5);
      c.strokeRect(west, north, east - west, south - north);
      const { checked, path } = scene;
      if (checked) this.infeasible(checked, scene.fresh);
      if (path) this.path(path, scene.outline);
      else if (checked) this.trail(checked, 0, checked.time.count);
      if (path && !scene.bare) this.points(path, scene);
      if (checked) this.marks(checked, scene);
      this.hand(scene);
    });
  }

  private at([x, y]: Point): Point {
    return [this.plane.px(x), this.plane.py(y)];
  }

  /** The curve, and the straight edges between the points where they are not the curve. */
  private path(path: DrawnPath, outline: Outline | null): void {
    const { c } = this.canvas;
    c.lineJoin = 'round';
    if (path.geometry === 'spline') {
      this.canvas.pen('muted', 1, 'dot');
      this.outline(polygon(path));
    }
    this.canvas.pen('text', 1.5);
    if (outline) this.outline(outline);
  }

  private outline(outline: Outline): void {
    const { c } = this.canvas;
    const { x, y } = thinned(outline, NEAR / this.plane.scale);
    c.beginPath();
    this.trace(x, y, 0, x.length);
    c.stroke();
  }

  /** The path as the server sampled it, from one bin to another. */
  private trail(checked: Checked, from: number, to: number): void {
    const { c } = this.canvas;
    const [x, y] = places(checked);
    if (!x || !y) return;
    this.canvas.pen('text', 1.5);
    c.beginPath();
    this.trace(x, y, from, to);
    c.stroke();
  }

  private trace(x: ArrayLike<number>, y: ArrayLike<number>, from: number, to: number): void {
    const at = (i: number) => this.at([x[i] as number, y[i] as number]);
    this.canvas.trace(Math.min(to, x.length), at, from);
  }

  private infeasible(checked: Checked, fresh: boolean): void {
    const { c } = this.canvas;
    const [x, y] = places(checked);
    if (!x || !y || checked.feasible) return;
    c.save();
    c.globalAlpha = fresh ? 1 : 0.5;
    c.lineWidth = 13;
    c.lineCap = 'round';
    c.lineJoin = 'round';
    c.strokeStyle = this.canvas.hatch('bad');
    c.beginPath();
    // A bin further than the last that is bad, so that one of a single bin has a length.
    for (const [from, to] of stretches(checked)) this.trace(x, y, from, to + 1);
    c.stroke();
    c.restore();
  }

  private points(path: DrawnPath, { chosen, stroke }: Scene): void {
    const { c, palette: inks } = this.canvas;
    const beyond = new Set(outside(path.points, stroke));
    const side = path.points.length > MANY ? 2.5 : 4;
    const dot = this.dot(side);
    const wide = dot.width / devicePixelRatio;
    path.points.forEach((point, i) => {
      if (i === 0 || chosen.has(i) || beyond.has(i)) return;
      const [px, py] = this.at(point);
      c.drawImage(dot, px - wide / 2, py - wide / 2, wide, wide);
    });
    path.points.forEach((point, i) => {
      if (i !== 0 && !chosen.has(i) && !beyond.has(i)) return;
      const [px, py] = this.at(point);
      const lit = chosen.has(i);
      const reach = lit ? side + 2 : side;
      c.beginPath();
      if (i === 0) c.rect(px - reach, py - reach, 2 * reach, 2 * reach);
      else c.arc(px, py, reach, 0, 2 * Math.PI);
      c.fillStyle = beyond.has(i) ? inks.bad : lit ? inks.focus : inks.panel;
      c.fill();
      c.lineWidth = 1.75;
      c.strokeStyle = beyond.has(i) ? inks.bad : lit ? inks.focus : inks.text;
      c.stroke();
      if (!beyond.has(i)) return;
      this.canvas.lines([
        [px - 9, py - 9, px + 9, py + 9],
        [px - 9, py + 9, px + 9, py - 9],
      ]);
    });
  }

  /** What the hand is doing: a box around points, a stroke. */
  private hand({ band, sketch }: Scene): void {
    const { c } = this.canvas;
    if (band) {
      const [[ax, ay], [bx, by]] = [this.at(band[0]), this.at(band[1])];
      this.canvas.pen('focus', 1, 'dash');
      c.strokeRect(ax, ay, bx - ax, by - ay);
    }
    if (!sketch) return;
    this.canvas.pen('focus', 2);
    c.beginPath();
    this.canvas.trace(sketch.length, (i) => this.at(sketch[i] as Point));
    c.stroke();
  }

  /** Returns a point that is like others as a picture: to outline hundreds anew takes milliseconds. */
  private dot(side: number): ImageBitmap {
    const known = this.dots.get(side);
    if (known) return known;
    const wide = 2 * Math.ceil((side + 2) * devicePixelRatio);
    const drawn = new OffscreenCanvas(wide, wide);
    const c = drawn.getContext('2d') as OffscreenCanvasRenderingContext2D;
    c.translate(wide / 2, wide / 2);
    c.scale(devicePixelRatio, devicePixelRatio);
    c.lineWidth = 1.75;
    c.fillStyle = this.canvas.palette.panel;
    c.strokeStyle = this.canvas.palette.text;
    c.arc(0, 0, side, 0, 2 * Math.PI);
    c.fill();
    c.stroke();
    // Of a canvas, the browser takes another picture each time that it is drawn.
    const made = drawn.transferToImageBitmap();
    this.dots.set(side, made);
    return made;
  }

  /** Numbers at the worst places, as in the list, and where the cursor of the plots is. */
  private marks(checked: Checked, { cursor, fresh }: Scene): void {
    const { canvas } = this;
    const [x, y] = places(checked);
    if (cursor !== null && x && y && cursor < x.length) {
      const [px, py] = this.at([x[cursor] as number, y[cursor] as number]);
      canvas.dot(px, py, 5, 'focus');
    }
    if (!fresh) return;
    const taken: Point[] = [];
    checked.violations.slice(0, NUMBERED).forEach(({ place }, i) => {
      const [px, py] = this.at(place);
      if (taken.some(([x, y]) => Math.hypot(x - px, y - py) < APART)) return;
      taken.push([px, py]);
      const [bx, by] = [px + 14, py - 14];
      canvas.pen('bad');
      canvas.lines([[px, py, bx, by]]);
      canvas.dot(bx, by, 8, 'bad');
      canvas.font(11, 600);
      canvas.write(String(i + 1), bx, by + 0.5, { align: 'center', ink: 'panel' });
    });
  }
}

function places(checked: Checked): [Float32Array | undefined, Float32Array | undefined] {
  return [checked.columns.get('x.position')?.minimum, checked.columns.get('y.position')?.minimum];
}
