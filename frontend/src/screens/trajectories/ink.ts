/** Colours of this screen's canvases, read from the tokens of app.css. */

const TOKENS = {
  panel: '--panel',
  well: '--well',
  grid: '--grid',
  axis: '--axis',
  text: '--text',
  strong: '--strong',
  path: '--reference',
  x: '--phase-a',
  y: '--phase-b',
  bad: '--bad',
  focus: '--focus',
  a: '--a',
  b: '--b',
} as const;

export type Inks = Record<keyof typeof TOKENS, string>;

export function readInks(element: Element): Inks {
  const style = getComputedStyle(element);
  const found = Object.entries(TOKENS).map(([name, token]) => [
    name,
    style.getPropertyValue(token).trim(),
  ]);
  return Object.fromEntries(found) as Inks;
}

/** Returns a pattern of slanted lines, so that what is infeasible does not depend on colour. */
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
