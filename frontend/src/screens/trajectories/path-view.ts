/** The stroke from above at equal scales: grid, path, points, and what is infeasible on it. */

import { multiples, roundStep } from '../../plot/range';
import { minus } from '../../ui/units';
import { outside, type DrawnPath, type Point } from './drawn-path';
import { stretches, type Checked } from './feasibility';
import { outline } from './geometry';
import { hatching, type Inks } from './ink';

const MARGIN = { left: 40, right: 16, top: 12, bottom: 22 };
/** Numbered places of the worst violations. */
const NUMBERED = 8;
/** Places nearer than this share the first number, CSS pixels. */
const APART = 20;
/** Length of what a curve is drawn in, CSS pixels. */
const SEGMENT = 2;
/** More points than this are drawn small. */
const MANY = 60;
const ZOOM = { least: 0.7, most: 2000 };

export interface Scene {
  path: DrawnPath | null;
  selected: number | null;
  found: Checked | null;
  /** Whether `found` is of the path as it stands; else it is drawn paler. */
  fresh: boolean;
  cursor: number | null;
  stroke: Point;
}

export class PathView {
  private width = 1;
  private height = 1;
  private stroke: Point = [0.085, 0.145];
  private zoom = 1;
  private centre: Point = [0, 0];
  private readonly hatch: CanvasPattern | null;
  private readonly family: string;
  /** Pictures of a point by its size. */
  private readonly dots = new Map<number, HTMLCanvasElement>();

  constructor(
    private readonly c: CanvasRenderingContext2D,
    private readonly inks: Inks,
  ) {
    this.hatch = hatching(c, inks.bad);
    this.family = getComputedStyle(c.canvas).fontFamily;
  }

  /** CSS pixels per metre. */
  get scale(): number {
    const { left, right, top, bottom } = MARGIN;
    const fit = Math.min(
      (this.width - left - right) / (2.1 * this.stroke[0]),
      (this.height - top - bottom) / (2.1 * this.stroke[1]),
    );
    return Math.max(1, fit) * this.zoom;
  }

  resize(width: number, height: number): void {
    [this.width, this.height] = [Math.max(1, width), Math.max(1, height)];
    this.c.canvas.width = Math.round(this.width * devicePixelRatio);
    this.c.canvas.height = Math.round(this.height * devicePixelRatio);
    this.dots.clear();
  }

  /** Keeps zoom and centre when the view is made anew, for another theme. */
  like(other: PathView | null): this {
    if (other) [this.zoom, this.centre] = [other.zoom, other.centre];
    return this;
  }

  /** Returns where a place is, CSS pixels. */
  at([x, y]: Point): Point {
    const { left, right, top, bottom } = MARGIN;
    return [
      (this.width + left - right) / 2 + (x - this.centre[0]) * this.scale,
      (this.height + top - bottom) / 2 - (y - this.centre[1]) * this.scale,
    ];
  }

  /** Returns which place is at some pixels. */
  place([px, py]: Point): Point {
    const [ox, oy] = this.at([0, 0]);
    return [(px - ox) / this.scale, (oy - py) / this.scale];
  }

  /** Zooms about a place under the pointer, which stays there. */
  zoomAt(pixels: Point, factor: number): void {
    const before = this.place(pixels);
    this.zoom = Math.min(ZOOM.most, Math.max(ZOOM.least, this.zoom * factor));
    const after = this.place(pixels);
    this.pan([before[0] - after[0], before[1] - after[1]]);
  }

  pan([dx, dy]: Point): void {
    this.centre = [this.centre[0] + dx, this.centre[1] + dy];
  }

  /** Shows the whole stroke, or all of some points. */
  fit(points: readonly Point[] = []): void {
    [this.zoom, this.centre] = [1, [0, 0]];
    if (points.length < 2) return;
    const [xs, ys] = [points.map(([x]) => x), points.map(([, y]) => y)];
    const [west, east] = [Math.min(...xs), Math.max(...xs)];
    const [south, north] = [Math.min(...ys), Math.max(...ys)];
    this.centre = [(west + east) / 2, (south + north) / 2];
    const wanted = Math.min(
      (this.width - MARGIN.left - MARGIN.right) / Math.max(1e-6, 1.3 * (east - west)),
      (this.height - MARGIN.top - MARGIN.bottom) / Math.max(1e-6, 1.3 * (north - south)),
    );
    this.zoom = Math.min(ZOOM.most, Math.max(ZOOM.least, wanted / this.scale));
  }

  draw(scene: Scene): void {
    const { c } = this;
    this.stroke = scene.stroke;
    c.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
    c.clearRect(0, 0, this.width, this.height);
    this.field();
    c.save();
    c.beginPath();
    c.rect(MARGIN.left, 0, this.width - MARGIN.left, this.height - MARGIN.bottom);
    c.clip();
    if (scene.found) this.infeasible(scene.found, scene.fresh);
    if (scene.path) this.path(scene.path);
    else if (scene.found) this.trail(scene.found, 0, scene.found.time.count);
    if (scene.path) this.points(scene.path, scene);
    if (scene.found) this.marks(scene.found, scene);
    c.restore();
  }

  /** The stroke, lighter than what lies beyond, with a round grid and its numbers. */
  private field(): void {
    const { c, inks } = this;
    const [west, north] = this.at([-this.stroke[0], this.stroke[1]]);
    const [east, south] = this.at([this.stroke[0], -this.stroke[1]]);
    c.fillStyle = inks.well;
    c.fillRect(MARGIN.left, 0, this.width - MARGIN.left, this.height - MARGIN.bottom);
    c.save();
    c.beginPath();
    c.rect(MARGIN.left, 0, this.width - MARGIN.left, this.height - MARGIN.bottom);
    c.clip();
    c.fillStyle = inks.panel;
    c.fillRect(west, north, east - west, south - north);
    c.restore();
    this.grid();
    c.save();
    c.beginPath();
    c.rect(MARGIN.left, 0, this.width - MARGIN.left, this.height - MARGIN.bottom);
    c.clip();
    c.strokeStyle = inks.strong;
    c.lineWidth = 1.5;
    c.strokeRect(west, north, east - west, south - north);
    c.restore();
  }

  private grid(): void {
    const { c, inks } = this;
    const [west, north] = this.place([MARGIN.left, 0]);
    const [east, south] = this.place([this.width, this.height - MARGIN.bottom]);
    const step = roundStep(44 / this.scale);
    const places = Math.max(0, Math.ceil(-Math.log10(step * 1e3) - 1e-9));
    const text = (value: number) => minus((value * 1e3).toFixed(places));
    c.strokeStyle = inks.grid;
    c.fillStyle = inks.axis;
    c.lineWidth = 1;
    c.font = `11px ${this.family}`;
    c.textBaseline = 'middle';
    c.textAlign = 'right';
    c.beginPath();
    for (const y of multiples({ from: south, to: north }, step)) {
      const at = Math.round(this.at([0, y])[1]) + 0.5;
      c.moveTo(MARGIN.left, at);
      c.lineTo(this.width, at);
      if (at > 8) c.fillText(text(y), MARGIN.left - 5, at);
    }
    c.textAlign = 'center';
    const columns = multiples({ from: west, to: east }, step);
    columns.forEach((x, i) => {
      const at = Math.round(this.at([x, 0])[0]) + 0.5;
      c.moveTo(at, 0);
      c.lineTo(at, this.height - MARGIN.bottom);
      if (at < MARGIN.left + 12 || at > this.width - 22) return;
      const last = i >= columns.length - 2 && at > this.width - 22 - step * this.scale;
      c.fillText(last ? `${text(x)} mm` : text(x), at, this.height - 9);
    });
    c.stroke();
  }

  private path(path: DrawnPath): void {
    const { c, inks } = this;
    const { curve } = outline(path, SEGMENT / this.scale);
    c.strokeStyle = inks.text;
    c.lineWidth = 1.5;
    c.lineJoin = 'round';
    c.setLineDash([]);
    c.beginPath();
    curve.forEach((point, i) => {
      const [px, py] = this.at(point);
      if (i === 0) c.moveTo(px, py);
      else c.lineTo(px, py);
    });
    c.stroke();
  }

  /** The path as the server sampled it, from one bin to another. */
  private trail(found: Checked, from: number, to: number): void {
    const { c, inks } = this;
    const [x, y] = places(found);
    if (!x || !y) return;
    c.strokeStyle = inks.text;
    c.lineWidth = 1.5;
    c.beginPath();
    this.trace(x, y, from, to);
    c.stroke();
  }

  private trace(x: Float32Array, y: Float32Array, from: number, to: number): void {
    for (let i = from; i < Math.min(to, x.length); i++) {
      const [px, py] = this.at([x[i] as number, y[i] as number]);
      if (i === from) this.c.moveTo(px, py);
      else this.c.lineTo(px, py);
    }
  }

  private infeasible(found: Checked, fresh: boolean): void {
    const { c, inks } = this;
    const [x, y] = places(found);
    if (!x || !y || found.feasible) return;
    c.save();
    c.globalAlpha = fresh ? 1 : 0.5;
    c.lineWidth = 13;
    c.lineCap = 'round';
    c.lineJoin = 'round';
    c.strokeStyle = this.hatch ?? inks.bad;
    c.beginPath();
    // A bin further than the last that is bad, so that one of a single bin has a length.
    for (const [from, to] of stretches(found)) this.trace(x, y, from, to + 1);
    c.stroke();
    c.restore();
  }

  private points(path: DrawnPath, { selected, stroke }: Scene): void {
    const { c, inks } = this;
    const beyond = new Set(outside(path.points, stroke));
    const side = path.points.length > MANY ? 2.5 : 4;
    const dot = this.dot(side);
    const wide = dot.width / devicePixelRatio;
    path.points.forEach((point, i) => {
      if (i === 0 || i === selected || beyond.has(i)) return;
      const [px, py] = this.at(point);
      c.drawImage(dot, px - wide / 2, py - wide / 2, wide, wide);
    });
    path.points.forEach((point, i) => {
      if (i !== 0 && i !== selected && !beyond.has(i)) return;
      const [px, py] = this.at(point);
      const chosen = i === selected;
      const reach = chosen ? side + 2 : side;
      c.beginPath();
      if (i === 0) c.rect(px - reach, py - reach, 2 * reach, 2 * reach);
      else c.arc(px, py, reach, 0, 2 * Math.PI);
      c.fillStyle = beyond.has(i) ? inks.bad : chosen ? inks.focus : inks.panel;
      c.fill();
      c.lineWidth = 1.75;
      c.strokeStyle = beyond.has(i) ? inks.bad : chosen ? inks.focus : inks.text;
      c.stroke();
      if (!beyond.has(i)) return;
      c.beginPath();
      c.moveTo(px - 9, py - 9);
      c.lineTo(px + 9, py + 9);
      c.moveTo(px - 9, py + 9);
      c.lineTo(px + 9, py - 9);
      c.stroke();
    });
  }

  /** Returns a point that is like others as a picture: to outline hundreds anew takes milliseconds. */
  private dot(side: number): HTMLCanvasElement {
    const known = this.dots.get(side);
    if (known) return known;
    const made = document.createElement('canvas');
    made.width = made.height = 2 * Math.ceil((side + 2) * devicePixelRatio);
    const c = made.getContext('2d') as CanvasRenderingContext2D;
    c.translate(made.width / 2, made.height / 2);
    c.scale(devicePixelRatio, devicePixelRatio);
    c.lineWidth = 1.75;
    c.fillStyle = this.inks.panel;
    c.strokeStyle = this.inks.text;
    c.arc(0, 0, side, 0, 2 * Math.PI);
    c.fill();
    c.stroke();
    this.dots.set(side, made);
    return made;
  }

  /** Numbers at the worst places, as in the list, and where the cursor of the plots is. */
  private marks(found: Checked, { cursor, fresh }: Scene): void {
    const { c, inks } = this;
    const [x, y] = places(found);
    if (cursor !== null && x && y && cursor < x.length) {
      const [px, py] = this.at([x[cursor] as number, y[cursor] as number]);
      c.beginPath();
      c.arc(px, py, 5, 0, 2 * Math.PI);
      c.fillStyle = inks.focus;
      c.fill();
    }
    if (!fresh) return;
    const taken: Point[] = [];
    found.violations.slice(0, NUMBERED).forEach(({ place }, i) => {
      const [px, py] = this.at(place);
      if (taken.some(([x, y]) => Math.hypot(x - px, y - py) < APART)) return;
      taken.push([px, py]);
      const [bx, by] = [px + 14, py - 14];
      c.strokeStyle = inks.bad;
      c.lineWidth = 1;
      c.beginPath();
      c.moveTo(px, py);
      c.lineTo(bx, by);
      c.stroke();
      c.beginPath();
      c.arc(bx, by, 8, 0, 2 * Math.PI);
      c.fillStyle = inks.bad;
      c.fill();
      c.fillStyle = inks.panel;
      c.font = `600 11px ${this.family}`;
      c.textAlign = 'center';
      c.textBaseline = 'middle';
      c.fillText(String(i + 1), bx, by + 0.5);
    });
  }
}

function places(found: Checked): [Float32Array | undefined, Float32Array | undefined] {
  return [found.columns.get('x.position')?.minimum, found.columns.get('y.position')?.minimum];
}
