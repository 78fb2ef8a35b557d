/** A shown plot as SVG and PNG, with title and legend, in the light theme as on paper. */

import { readPalette } from './palette';
import type { ShownPlot } from './plot-menu';
import { escaped, SvgCanvas } from './svg-canvas';

/** Pixels of a PNG for each CSS pixel. */
const FINE = 2;
const EDGE = 10;
/** Least height of curves over time, CSS pixels. */
const LEAST = 200;
const LINE = 20;
const SWATCH = 22;
const GAP = 16;
/** Parts of a legend that change under the pointer. */
const READINGS = '.value, .change, .push, .unit-now';

export interface Picture {
  title: string;
  svg: string;
  width: number;
  height: number;
}

interface Key {
  text: string;
  swatch: string;
}

/** Draws a plot once more, as SVG. */
export async function pictureOf(plot: ShownPlot): Promise<Picture> {
  const { element, width } = plot.canvas;
  // Scopes are low where many stand below each other.
  const low = plot.data && 'source' in plot.data() ? LEAST : 0;
  const height = Math.max(plot.canvas.height, low);
  const around = element.closest('figure, section');
  const copy = document.createElement('canvas');
  copy.style.cssText = 'position:absolute;visibility:hidden;pointer-events:none';
  element.after(copy);
  const light = lightly(() => ({ palette: readPalette(element), keys: legendOf(around) }));
  const canvas = new SvgCanvas(copy, light.palette);
  canvas.resize(width, height);
  try {
    plot.use(canvas);
    await frame();
    await frame();
  } finally {
    plot.use(plot.canvas);
    copy.remove();
  }
  const title = titleOf(around);
  const head = headOf(canvas, { title, note: noteOf(around), keys: light.keys });
  const [wide, tall] = [width + 2 * EDGE, height + head.height + EDGE];
  const svg = [
    `<svg xmlns="http://www.w3.org/2000/svg" width="${wide}" height="${tall}" viewBox="0 0 ${wide} ${tall}">`,
    `<title>${escaped(title)}</title>`,
    `<rect width="${wide}" height="${tall}" fill="${light.palette.panel}"/>`,
    head.content,
    `<g transform="translate(${EDGE} ${head.height})">${canvas.content}</g>`,
    '</svg>',
  ].join('\n');
  return { title, svg, width: wide, height: tall };
}

/** Returns a picture as PNG, at twice the resolution. */
export async function pngOf({ svg, width, height }: Picture): Promise<Blob> {
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}`;
  await image.decode();
  const canvas = document.createElement('canvas');
  [canvas.width, canvas.height] = [FINE * width, FINE * height];
  canvas.getContext('2d')?.drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((done, fail) => {
    canvas.toBlob((blob) => (blob ? done(blob) : fail(new Error('no PNG'))), 'image/png');
  });
}

/** Title, what else is said of the plot, and its legend in as many rows as it takes. */
function headOf(
  canvas: SvgCanvas,
  { title, note, keys }: { title: string; note: string; keys: readonly Key[] },
): { content: string; height: number } {
  const { c, palette } = canvas;
  const family = escaped(getComputedStyle(document.body).fontFamily);
  const letters = (size: number, weight = 400) =>
    `font-family="${family}" font-size="${size}" font-weight="${weight}"`;
  canvas.font(13, 600);
  const after = EDGE + c.measureText(title).width + 10;
  const parts = [
    `<text x="${EDGE}" y="18" ${letters(13, 600)} fill="${palette.text}">${escaped(title)}</text>`,
    `<text x="${after}" y="18" ${letters(12)} fill="${palette.muted}">${escaped(note)}</text>`,
  ];
  canvas.font(12);
  let [x, row] = [EDGE, 0];
  for (const { text, swatch } of keys) {
    const wide = SWATCH + 6 + c.measureText(text).width + GAP;
    if (x > EDGE && x + wide > canvas.width + EDGE) [x, row] = [EDGE, row + 1];
    const y = 30 + row * LINE;
    parts.push(
      `<g transform="translate(${x} ${y})">${swatch}</g>`,
      `<text x="${x + SWATCH + 6}" y="${y + 10}" ${letters(12)} fill="${palette.text}">${escaped(text)}</text>`,
    );
    x += wide;
  }
  return { content: parts.join('\n'), height: 28 + (keys.length > 0 ? (row + 1) * LINE : 0) };
}

function titleOf(around: Element | null): string {
  const title = around?.querySelector('h3, figure > header > b') ?? null;
  const heading = around?.matches('figure') ? around.querySelector('b') : title;
  return textOf(heading) || (around?.getAttribute('aria-label') ?? 'Plot');
}

function noteOf(around: Element | null): string {
  return textOf(around?.querySelector('header .note, h3 + .note') ?? null);
}

function legendOf(around: Element | null): Key[] {
  return [...(around?.querySelectorAll('svg.swatch') ?? [])].map((swatch) => ({
    text: textOf(swatch.parentElement),
    swatch: standing(swatch),
  }));
}

/** The text of an element without what changes under the pointer. */
function textOf(element: Element | null): string {
  const copy = element?.cloneNode(true) as Element | undefined;
  copy?.querySelectorAll(READINGS).forEach((each) => each.remove());
  return (copy?.textContent ?? '').replace(/\s+/g, ' ').trim();
}

/** An SVG of the page by itself: colours in place of the names that a style sheet explains. */
function standing(svg: Element): string {
  const style = getComputedStyle(svg);
  const text = new XMLSerializer().serializeToString(svg);
  return text.replace(/var\((--[\w-]+)\)/g, (_, name: string) => style.getPropertyValue(name));
}

/** Reads colours as they are in the light theme; nothing is painted meanwhile. */
function lightly<T>(read: () => T): T {
  const { dataset } = document.documentElement;
  const before = dataset.theme;
  dataset.theme = 'light';
  try {
    return read();
  } finally {
    if (before === undefined) delete dataset.theme;
    else dataset.theme = before;
  }
}

function frame(): Promise<void> {
  return new Promise((done) => requestAnimationFrame(() => done()));
}
