/** What HeatMap draws: its cells pixel by pixel, lines and points over them, the colour bar. */

import { drawName } from './axes';
import type { AxisScale } from './axis-scale';
import { crisp, markerAt, type Box, type Canvas } from './canvas';
import { lookup, pixelOf, steps, type ColourMap } from './colour-map';
import { cellsOf, paint, type Rows } from './heat-grid';
import { tracePath } from './series-drawing';
import type { Line, Numbers, Spot } from './types';

/** Dark with a light rim, so that lines and points show on every colour. */
const [DARK, LIGHT] = ['#000000', '#ffffff'];
const BAR = 12;

export interface Cells {
  x: AxisScale;
  y: AxisScale;
  between: { x: readonly number[]; y: readonly number[] };
  rows: Rows;
  colour: AxisScale;
  map: ColourMap;
  region?: readonly (readonly boolean[])[] | undefined;
}

/** Cells by pixel, so that a logarithmic axis has no seams; kept, as the cursor only lies over it. */
export function heatPicture({ palette }: Canvas, box: Box, cells: Cells): HTMLCanvasElement {
  const { x, y, between, rows, colour, map, region } = cells;
  const picture = document.createElement('canvas');
  const width = (picture.width = Math.max(
    1,
    Math.round((box.right - box.left) * devicePixelRatio),
  ));
  const height = (picture.height = Math.max(
    1,
    Math.round((box.bottom - box.top) * devicePixelRatio),
  ));
  const context = picture.getContext('2d');
  if (!context) return picture;
  const [foot] = colour.pixels;
  const image = context.createImageData(width, height);
  paint(new Uint32Array(image.data.buffer), {
    width,
    height,
    columns: cellsOf(x, between.x, box.left, width, devicePixelRatio),
    lines: cellsOf(y, between.y, box.top, height, devicePixelRatio),
    rows,
    colours: lookup(map),
    region,
    share: (value) => 1 - colour.px(value) / foot,
    ground: pixelOf(palette.panel),
    hatch: pixelOf(palette.border),
  });
  context.putImageData(image, 0, 0);
  return picture;
}

export function drawOverlay(
  canvas: Canvas,
  { x, y }: Cells,
  lines: readonly Line[],
  points: readonly Spot[],
): void {
  const { c, palette } = canvas;
  for (const line of lines) {
    const { ink, width = 1.6, dash } = line;
    tracePath(canvas, line, x, y);
    canvas.pen('text', 1.9 * width);
    c.strokeStyle = palette.panel;
    c.globalAlpha = 0.75;
    c.stroke();
    c.globalAlpha = 1;
    canvas.pen(ink ?? 'text', width, dash);
    c.stroke();
  }
  c.setLineDash([]);
  writeOnLines(canvas, lines, points, x, y);
  for (const { x: atX, y: atY, label, ink, marker } of points) {
    const [px, py] = [x.px(atX), y.px(atY)];
    if (!Number.isFinite(px + py)) continue;
    const shape = canvas.shape(markerAt(marker ?? 'circle', px, py, 4));
    for (const [colour, width] of [
      [DARK, 4],
      [LIGHT, 1.6],
    ] as const) {
      c.lineWidth = width;
      c.strokeStyle = colour;
      if (colour === LIGHT) {
        c.fillStyle = ink ? palette[ink] : LIGHT;
        c.fill(shape);
      }
      c.stroke(shape);
    }
    if (!label) continue;
    canvas.font(11, 600);
    const late = px + c.measureText(label).width + 10 > x.pixels[1];
    c.fillStyle = LIGHT;
    canvas.write(label, px + (late ? -8 : 8), py - 10, {
      align: late ? 'right' : 'left',
      rim: DARK,
    });
  }
}

/** Shares of a line at which its label may stand, and half of a label's height. */
const PLACES = [0.5, 0.35, 0.65, 0.2, 0.8];
const HALF = 7;

/** Labels of lines, each on the longest piece of its own, where none stands that was written before. */
function writeOnLines(
  canvas: Canvas,
  lines: readonly Line[],
  points: readonly Spot[],
  x: AxisScale,
  y: AxisScale,
): void {
  canvas.font(10, 600);
  canvas.c.fillStyle = DARK;
  const taken = points.map((spot) => ({ px: x.px(spot.x), py: y.px(spot.y), half: 10 }));
  // Bold lines first: where there is room for few labels, it is theirs.
  const wide = [...lines].sort((one, other) => (other.width ?? 1.6) - (one.width ?? 1.6));
  for (const { label, x: xs, y: ys } of wide) {
    if (label === undefined) continue;
    const half = canvas.c.measureText(label).width / 2 + 4;
    const [begin, length] = longest(xs, ys, x, y);
    const place = PLACES.map((share) => begin + Math.floor(length * share))
      .map((at) => ({ px: x.px(xs[at]), py: y.px(ys[at]), half }))
      .find(({ px, py }) => {
        const inside = px - half > x.pixels[0] && px + half < x.pixels[1];
        const free = taken.every(
          (one) => Math.abs(one.py - py) > 2 * HALF || Math.abs(one.px - px) > one.half + half,
        );
        return inside && free;
      });
    if (!place) continue;
    taken.push(place);
    canvas.write(label, place.px, place.py, { align: 'center', rim: LIGHT });
  }
}

/** Begin and length of the longest piece of a line within the plot. */
function longest(xs: Numbers, ys: Numbers, x: AxisScale, y: AxisScale): [number, number] {
  let [begin, length] = [0, 0];
  for (let i = 0, from = 0; i <= xs.length; i++) {
    const [px, py] = [xs[i] ?? null, ys[i] ?? null];
    if (px !== null && py !== null && x.holds(px) && y.holds(py)) continue;
    if (i - from > length) [begin, length] = [from, i - from];
    from = i + 1;
  }
  return [begin, length];
}

/** The frame of the cell that is read. */
export function drawCell(canvas: Canvas, { x, y, between }: Cells, i: number, j: number): void {
  const { c } = canvas;
  const [left, right] = [x.px(between.x[i]), x.px(between.x[i + 1])];
  const [bottom, top] = [y.px(between.y[j]), y.px(between.y[j + 1])];
  if (!Number.isFinite(left + right + bottom + top)) return;
  c.setLineDash([]);
  for (const [colour, width] of [
    [DARK, 3],
    [LIGHT, 1.5],
  ] as const) {
    c.strokeStyle = colour;
    c.lineWidth = width;
    c.strokeRect(left, top, right - left, bottom - top);
  }
}

/** What the colours mean, at the right of the map. */
export function drawColourBar(
  canvas: Canvas,
  scale: AxisScale,
  map: ColourMap,
  left: number,
  top: number,
) {
  const { c } = canvas;
  const [height] = scale.pixels;
  const gradient = c.createLinearGradient(0, top + height, 0, top);
  for (const { offset, colour } of steps(map)) gradient.addColorStop(offset, colour);
  c.fillStyle = gradient;
  c.fillRect(left, top, BAR, height);
  canvas.pen('strong');
  c.strokeRect(crisp(left), crisp(top), BAR, height);
  const ticks = scale
    .ticks(34)
    .map(({ value, text }) => ({ text, at: crisp(top + scale.px(value)) }));
  canvas.lines(ticks.map(({ at, text }) => [left + BAR, at, left + BAR + (text ? 4 : 2), at]));
  canvas.font();
  for (const { at, text } of ticks) canvas.write(text, left + 19, at, { ink: 'axis' });
  drawName(canvas, scale, left + 62, top + height / 2, true);
}
