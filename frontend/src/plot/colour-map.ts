/** Colours of maps of values. */

export type ColourMap = 'sequential' | 'diverging';

const VIRIDIS = [
  '#440154',
  '#48186a',
  '#472d7b',
  '#424086',
  '#3b528b',
  '#33638d',
  '#2c728e',
  '#26828e',
  '#21918c',
  '#1fa088',
  '#28ae80',
  '#3fbc73',
  '#5ec962',
  '#84d44b',
  '#addc30',
  '#d8e219',
  '#fde725',
];

/** The page's blue and vermilion, darkened at the ends, grey in the middle. */
const BLUE_ORANGE = ['#00345c', '#0072b2', '#7fb2d6', '#eeeeec', '#eba772', '#d55e00', '#6e2a00'];

const STOPS: Record<ColourMap, readonly string[]> = {
  sequential: VIRIDIS,
  diverging: BLUE_ORANGE,
};

const LEVELS = 256;

/** Colours of a map as 256 values of an ImageData's 32-bit pixels (little endian: ABGR). */
export function lookup(map: ColourMap): Uint32Array {
  const stops = STOPS[map].map(rgb);
  return Uint32Array.from({ length: LEVELS }, (_, i) => {
    const at = (i / (LEVELS - 1)) * (stops.length - 1);
    const k = Math.min(stops.length - 2, Math.floor(at));
    const [low, high] = [stops[k] ?? [0, 0, 0], stops[k + 1] ?? [0, 0, 0]];
    const mix = [0, 1, 2].map((c) =>
      Math.round((low[c] ?? 0) + ((high[c] ?? 0) - (low[c] ?? 0)) * (at - k)),
    );
    return pixel(mix);
  });
}

/** The stops of a map as an svg gradient takes them, from low to high. */
export function steps(map: ColourMap): { offset: number; colour: string }[] {
  const stops = STOPS[map];
  return stops.map((colour, i) => ({ offset: i / (stops.length - 1), colour }));
}

/** A colour `#rrggbb`, or as a minifier writes it `#rgb`, as an ImageData pixel. */
export function pixelOf(colour: string): number {
  return pixel(rgb(colour));
}

function rgb(hex: string): number[] {
  const colour = hex.length === 4 ? hex.replace(/[^#]/g, '$&$&') : hex;
  return [1, 3, 5].map((i) => Number.parseInt(colour.slice(i, i + 2), 16));
}

function pixel([r = 0, g = 0, b = 0]: readonly number[]): number {
  return ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;
}
