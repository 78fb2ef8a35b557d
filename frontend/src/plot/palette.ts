/** Colours of curves, read from the tokens of theme.css so that canvases follow the theme. */

const INKS = [
  'a',
  'b',
  'difference',
  'baseline',
  'candidate',
  'staged',
  'reference',
  'phase-a',
  'phase-b',
  'phase-c',
  'grid',
  'axis',
  'text',
  'muted',
  'border',
  'panel',
  'well',
  'strong',
  'focus',
  'good',
  'bad',
] as const;

export type Ink = (typeof INKS)[number];

export type Palette = Record<Ink, string>;

/** Returns the colours that hold for an element now. */
export function readPalette(element: Element): Palette {
  const style = getComputedStyle(element);
  const colours = INKS.map((ink) => [ink, style.getPropertyValue(`--${ink}`).trim()]);
  return Object.fromEntries(colours) as Palette;
}
