/** The logarithmic scale of a gain's slider, and its keys. */

export interface SliderScale {
  least: number;
  most: number;
}

/** Position of a value on its track, 0 to 1; values beyond the ends stay at them. */
export function position(value: number, { least, most }: SliderScale): number {
  if (!(value > least)) return 0;
  return Math.min(1, Math.log(value / least) / Math.log(most / least));
}

/** Value at a position, rounded to four digits. */
export function valueAt(place: number, { least, most }: SliderScale): number {
  const within = Math.min(1, Math.max(0, place));
  return Number((least * (most / least) ** within).toPrecision(4));
}

/** Value after a key, or null for keys that are not the slider's: 1 % a step, with shift 10 %. */
export function valueAfterKey(
  key: string,
  shift: boolean,
  value: number,
  scale: SliderScale,
): number | null {
  const ratio = shift ? 1.1 : 1.01;
  const bounded = (next: number) =>
    Number(Math.min(scale.most, Math.max(scale.least, next)).toPrecision(6));
  switch (key) {
    case 'ArrowRight':
    case 'ArrowUp':
      return bounded(value * ratio);
    case 'ArrowLeft':
    case 'ArrowDown':
      return bounded(value / ratio);
    case 'PageUp':
      return bounded(value * 1.1);
    case 'PageDown':
      return bounded(value / 1.1);
    case 'Home':
      return scale.least;
    case 'End':
      return scale.most;
    default:
      return null;
  }
}
