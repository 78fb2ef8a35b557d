/** Colours of curves, read from the tokens of theme.css so that canvases follow the theme. */

import type { Look } from './types';

const INKS = [
  'a',
  'b',
  'difference',
  'baseline',
  'candidate',
  'staged',
  'overlay-1',
  'overlay-2',
  'overlay-3',
  'overlay-4',
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

/** Colours of overlaid runs: none of A, B and the reference, told apart by colour-blind eyes too. */
export const RUN_INKS: readonly Ink[] = ['overlay-1', 'overlay-2', 'overlay-3', 'overlay-4'];

const LOOKS: readonly Look[] = [
  { ink: 'a' },
  { ink: 'b', marker: 'dot' },
  { ink: 'phase-a', dash: 'dash' },
  { ink: 'phase-b', dash: 'dot' },
];

/** Curves of a measurement, and of what has a name instead of a letter: no variant's colour. */
const MEASURED: readonly Look[] = [
  { ink: 'phase-a' },
  { ink: 'phase-b', dash: 'dash' },
  { ink: 'phase-c', dash: 'dot' },
];

/** The letter that stands for what was measured. */
const MEASUREMENT = 'M';

/** The look of a variant by its letter, alone or among others: markers tell B from A without colour. */
export function looksOf(variant: string): Look {
  if (variant === MEASUREMENT) return MEASURED[0] as Look;
  const place = Math.max(0, (variant.codePointAt(0) ?? 65) - 65);
  if (variant.length > 1) return MEASURED[place % MEASURED.length] as Look;
  return LOOKS[place % LOOKS.length] as Look;
}
