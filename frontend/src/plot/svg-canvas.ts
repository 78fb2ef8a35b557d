/** A drawing context that writes SVG: what is drawn through it is on a real canvas too. */

import { Canvas } from './canvas';
import type { Palette } from './palette';

/** Share of its size by which letters stand above the place that a baseline names. */
const DROPS: Partial<Record<CanvasTextBaseline, number>> = { middle: 0.35, top: 0.8, bottom: -0.2 };
const ANCHORS: Partial<Record<CanvasTextAlign, string>> = { center: 'middle', right: 'end' };
const SMALL = 1e-6;

type Style = string | CanvasGradient | CanvasPattern;

/** Writes text as XML. */
export function escaped(text: string): string {
  return text.replace(/[&<>"]/g, (sign) => `&#${sign.charCodeAt(0)};`);
}

const short = (value: number) => String(Math.round(value * 100) / 100);
const all = (...values: number[]) => values.map(short).join(' ');

class SvgWriter {
  private readonly definitions: string[] = [];
  private drawn: string[] = [];
  private path = '';
  /** Names of the clipping paths in effect, by depth of `save`. */
  private clips: string[] = [''];
  private readonly paths = new WeakMap<Path2D, string>();
  private readonly paints = new WeakMap<object, string>();

  constructor(private readonly real: CanvasRenderingContext2D) {}

  /** All that was drawn since everything was cleared. */
  get content(): string {
    return `<defs>${this.definitions.join('')}</defs>${this.drawn.join('\n')}`;
  }

  keep(shape: Path2D, path: string): void {
    this.paths.set(shape, path);
  }

  /** What is written besides being drawn, by name of the method. */
  readonly calls = {
    clearRect: () => (this.drawn = []),
    save: () => this.clips.push(this.clips.at(-1) ?? ''),
    restore: () => this.clips.length > 1 && this.clips.pop(),
    beginPath: () => (this.path = ''),
    closePath: () => (this.path += 'Z'),
    moveTo: (x: number, y: number) => (this.path += `M${all(x, y)}`),
    lineTo: (x: number, y: number) => (this.path += `${this.path ? 'L' : 'M'}${all(x, y)}`),
    rect: (x: number, y: number, width: number, height: number) =>
      (this.path += rectangle(x, y, width, height)),
    arc: (x: number, y: number, radius: number, from: number, to: number) =>
      (this.path += arc(x, y, radius, from, to)),
    clip: () => this.clips.splice(-1, 1, this.define(`<clipPath`, `<path d="${this.path}"/>`, 'clipPath')), // prettier-ignore
    stroke: (shape?: Path2D) => this.stroked(this.pathOf(shape)),
    fill: (shape?: Path2D) => this.filled(this.pathOf(shape)),
    strokeRect: (x: number, y: number, width: number, height: number) =>
      this.stroked(rectangle(x, y, width, height)),
    fillRect: (x: number, y: number, width: number, height: number) =>
      this.filled(rectangle(x, y, width, height)),
    fillText: (text: string, x: number, y: number) =>
      this.text(text, x, y, `fill="${this.paint(this.real.fillStyle)}"`),
    strokeText: (text: string, x: number, y: number) =>
      this.text(text, x, y, `fill="none" ${this.pen()}`),
    drawImage: (image: HTMLCanvasElement, x: number, y: number, width: number, height: number) =>
      this.add(
        `<image x="${short(x)}" y="${short(y)}" width="${short(width)}" height="${short(height)}" preserveAspectRatio="none" href="${image.toDataURL()}"`,
      ),
  };

  gradient(made: CanvasGradient, ends: readonly number[]): CanvasGradient {
    const stops: string[] = [];
    const add = made.addColorStop.bind(made);
    const [x1 = 0, y1 = 0, x2 = 0, y2 = 0] = ends.map(short);
    const place = this.definitions.push('') - 1;
    const name = `d${place}`;
    made.addColorStop = (offset, colour) => {
      add(offset, colour);
      stops.push(`<stop offset="${offset}" stop-color="${colour}"/>`);
      this.definitions[place] =
        `<linearGradient id="${name}" gradientUnits="userSpaceOnUse" x1="${x1}" y1="${y1}" x2="${x2}" y2="${y2}">${stops.join('')}</linearGradient>`;
    };
    this.paints.set(made, `url(#${name})`);
    return made;
  }

  pattern(made: CanvasPattern | null, tile: HTMLCanvasElement): CanvasPattern | null {
    const [width, height] = [tile.width, tile.height].map((size) => size / devicePixelRatio);
    const image = `<image width="${width}" height="${height}" href="${tile.toDataURL()}"/>`;
    const opening = `<pattern patternUnits="userSpaceOnUse" width="${width}" height="${height}"`;
    if (made) this.paints.set(made, `url(#${this.define(opening, image, 'pattern')})`);
    return made;
  }

  private define(opening: string, content: string, tag: string): string {
    const name = `d${this.definitions.length}`;
    this.definitions.push(`${opening} id="${name}">${content}</${tag}>`);
    return name;
  }

  private pathOf(shape?: Path2D): string {
    return shape ? (this.paths.get(shape) ?? '') : this.path;
  }

  private paint(style: Style): string {
    return typeof style === 'string' ? style : (this.paints.get(style) ?? 'none');
  }

  private pen(): string {
    const { real } = this;
    const dash = real.getLineDash();
    return [
      `stroke="${this.paint(real.strokeStyle)}" stroke-width="${short(real.lineWidth)}"`,
      `stroke-linejoin="${real.lineJoin}" stroke-linecap="${real.lineCap}"`,
      dash.length > 0 ? `stroke-dasharray="${all(...dash)}"` : '',
    ].join(' ');
  }

  private stroked(path: string): void {
    if (path) this.add(`<path d="${path}" fill="none" ${this.pen()}`);
  }

  private filled(path: string): void {
    if (path) this.add(`<path d="${path}" fill="${this.paint(this.real.fillStyle)}"`);
  }

  private text(text: string, x: number, y: number, look: string): void {
    const { font, textAlign, textBaseline } = this.real;
    const size = Number(/([\d.]+)px/.exec(font)?.[1] ?? 11);
    const weight = /^(?:\w+ )*(\d00|bold) /.exec(font)?.[1] ?? '400';
    const family = font.slice(font.indexOf('px') + 3);
    const drop = (DROPS[textBaseline] ?? 0) * size;
    this.add(
      `<text x="${short(x)}" y="${short(y + drop)}" text-anchor="${ANCHORS[textAlign] ?? 'start'}" font-size="${size}" font-weight="${weight}" font-family="${escaped(family)}" ${look}`,
      `${escaped(text.replace(/^ | $/g, '\u00a0'))}</text>`,
    );
  }

  /** Adds an element whose first tag is still open. */
  private add(opening: string, content = ''): void {
    const { real } = this;
    const clip = this.clips.at(-1);
    const { a, b, c, d, e, f } = real.getTransform();
    const moved = [a, b, c, d, e, f].map((each) => each / devicePixelRatio);
    const still = [1, 0, 0, 1, 0, 0].every((each, i) => Math.abs(each - (moved[i] ?? 0)) < SMALL);
    const element = [
      opening,
      real.globalAlpha < 1 ? ` opacity="${short(real.globalAlpha)}"` : '',
      still ? '' : ` transform="matrix(${moved.map((each) => each.toFixed(4)).join(' ')})"`,
      clip ? ` clip-path="url(#${clip})"` : '',
      content ? `>${content}` : '/>',
    ].join('');
    if (real.globalCompositeOperation === 'destination-over') this.drawn.unshift(element);
    else this.drawn.push(element);
  }
}

function rectangle(x: number, y: number, width: number, height: number): string {
  return `M${all(x, y)}h${short(width)}v${short(height)}h${short(-width)}Z`;
}

function arc(x: number, y: number, radius: number, from: number, to: number): string {
  const at = (angle: number) => all(x + radius * Math.cos(angle), y + radius * Math.sin(angle));
  const half = (from + to) / 2;
  const turn = (end: number) => `A${all(radius, radius)} 0 0 1 ${at(end)}`;
  return `M${at(from)}${turn(half)}${turn(to)}`;
}

/** A canvas that keeps what is drawn on it as SVG. Its element has to be in the document. */
export class SvgCanvas extends Canvas {
  override readonly alone = true;
  private readonly writer: SvgWriter;

  constructor(element: HTMLCanvasElement, palette: Palette) {
    const real = element.getContext('2d') as CanvasRenderingContext2D;
    const writer = new SvgWriter(real);
    const context = new Proxy(real, {
      get: (_, name) => member(real, writer, name as keyof CanvasRenderingContext2D),
      set: (_, name, value) => Reflect.set(real, name, value),
    });
    element.getContext = (() => context) as unknown as typeof element.getContext;
    super(element, palette);
    this.writer = writer;
  }

  /** Everything drawn, as elements of an SVG of this width and height. */
  get content(): string {
    return this.writer.content;
  }

  override shape(path: string): Path2D {
    const shape = super.shape(path);
    this.writer.keep(shape, path);
    return shape;
  }
}

function member(
  real: CanvasRenderingContext2D,
  writer: SvgWriter,
  name: keyof CanvasRenderingContext2D,
): unknown {
  const value: unknown = real[name];
  if (typeof value !== 'function') return value;
  const written = (writer.calls as Record<string, ((...values: never[]) => unknown) | undefined>)[
    name
  ];
  return (...values: never[]) => {
    // Before it is drawn: a call such as restore changes what is in effect.
    written?.(...values);
    const made = Reflect.apply(value, real, values) as unknown;
    if (name === 'createLinearGradient') return writer.gradient(made as CanvasGradient, values);
    if (name === 'createPattern') return writer.pattern(made as CanvasPattern, values[0] as never);
    return made;
  };
}
