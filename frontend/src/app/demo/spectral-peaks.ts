/** Lines and broad peaks of a spectrum, as analysis/spectrum.py defines them. */

export interface Spectrum {
  density: Float64Array;
  amplitude: Float64Array;
  rms: number;
  segment: number;
  resolution: number;
  noiseBandwidth: number;
}

interface Peak {
  frequency: number;
  density: number;
  rms: number;
  narrow: boolean;
}

interface Band {
  frequency: number;
  density: number;
  width: number;
}

const PEAKS_MAX = 20;
/** Of noise alone to have a line. */
const CHANCE = 1e-3;
/** Bins whose median is the level of the noise there. */
const BLOCK = 33;
/** Bins on either side of a line with less power than it. */
const AROUND = 10;
/** Bands of an octave, and least bins of one over all segments. */
const BANDS = 12;
const BAND_BINS = 32;
/** By how much a broad peak stands above its valleys. */
const PROMINENT = 4;

/** The strongest peaks, in order of frequency; a window's main lobe is so many bins wide on either side. */
export function peaksOf(spectrum: Spectrum, lobe: number, averages: number): Peak[] {
  const { lines, rest } = linesOf(spectrum, lobe, averages);
  return [...lines, ...broadOf(bandsOf(spectrum, rest, averages))]
    .sort((a, b) => b.rms - a.rms)
    .slice(0, PEAKS_MAX)
    .sort((a, b) => a.frequency - b.frequency);
}

/** Lines, and which bins belong to none. */
function linesOf(
  { density: S, resolution }: Spectrum,
  lobe: number,
  averages: number,
): { lines: Peak[]; rest: boolean[] } {
  const rest = Array<boolean>(S.length).fill(true);
  // Segments that share half of their samples count for at least those that share none.
  const degrees = (averages + 1) / 2;
  const half = share(0, degrees);
  const noise = noiseOf(S).map((median) => median / half);
  const high = share(quantile(CHANCE / S.length), degrees);
  const above = S.map((value, k) => Math.max(value - at(noise, k), 0));
  const powerAround = (k: number, reach: number) => {
    let power = 0;
    for (let i = Math.max(0, k - reach); i <= Math.min(S.length - 1, k + reach); i++) {
      if (rest[i]) power += at(above, i);
    }
    return power;
  };
  const candidates = [...S.keys()].filter((k) => {
    const value = at(S, k);
    return (
      value > high * at(noise, k) && value >= (S[k + 1] ?? 0) && value >= (S[k - 1] ?? Infinity)
    );
  });
  const lines: Peak[] = [];
  for (const k of candidates.sort((a, b) => at(S, b) - at(S, a))) {
    const power = powerAround(k, lobe);
    if (!rest[k] || power <= 0.5 * powerAround(k, AROUND)) continue;
    rest.fill(false, Math.max(0, k - lobe), k + lobe + 1);
    lines.push({
      frequency: resolution * (k + 1 + vertex(S[k - 1], at(S, k), S[k + 1])),
      density: at(S, k),
      rms: Math.sqrt(power * resolution),
      narrow: true,
    });
  }
  return { lines, rest };
}

/** The median of blocks of bins, interpolated between their middles. */
function noiseOf(S: Float64Array): Float64Array {
  const size = Math.min(BLOCK, S.length);
  const medians = Array.from({ length: Math.floor(S.length / size) }, (_, block) => {
    const sorted = S.slice(block * size, (block + 1) * size).sort();
    return (at(sorted, Math.floor((size - 1) / 2)) + at(sorted, Math.floor(size / 2))) / 2;
  });
  return S.map((_, k) => {
    const place = Math.min(Math.max(k / size - 0.5, 0), medians.length - 1);
    const left = Math.min(Math.floor(place), Math.max(0, medians.length - 2));
    const [a, b = a] = medians.slice(left, left + 2) as [number, number?];
    return a + (b - a) * (place - left);
  });
}

/** A quantile of chi squared of 2 K degrees over its mean (Wilson and Hilferty 1931). */
function share(normal: number, degrees: number): number {
  const spread = 1 / (9 * degrees);
  return (1 - spread + normal * Math.sqrt(spread)) ** 3;
}

/** What a normal variable exceeds with a small probability; its tail as a continued fraction. */
function quantile(probability: number): number {
  let [low, high] = [2, 40];
  for (let turn = 0; turn < 60; turn++) {
    const z = (low + high) / 2;
    let fraction = z;
    for (let k = 80; k > 0; k--) fraction = z + k / fraction;
    if (Math.exp((-z * z) / 2) / Math.sqrt(2 * Math.PI) / fraction > probability) low = z;
    else high = z;
  }
  return low;
}

/** Offset of the vertex of the parabola through three logarithms. */
function vertex(before: number | undefined, middle: number, after: number | undefined): number {
  if (!before || !after || middle <= 0) return 0;
  const [low, top, high] = [before, middle, after].map(Math.log) as [number, number, number];
  const bend = 2 * top - low - high;
  return bend > 0 ? (0.5 * (high - low)) / bend : 0;
}

function bandsOf({ density: S, resolution }: Spectrum, rest: boolean[], averages: number): Band[] {
  const least = Math.max(4, Math.ceil(BAND_BINS / averages));
  const bands: Band[] = [];
  let start = 0;
  while (start + least <= S.length) {
    const next = halfEven((start + 1) * 2 ** (1 / BANDS)) - 1;
    const stop = Math.min(Math.max(start + least, next), S.length);
    let [count, total] = [0, 0];
    for (let k = start; k < stop; k++) {
      if (!rest[k]) continue;
      count += 1;
      total += at(S, k);
    }
    if (count > 0 && total > 0) {
      bands.push({
        frequency: resolution * Math.sqrt((start + 1) * stop),
        density: total / count,
        width: resolution * (stop - start),
      });
    }
    start = stop;
  }
  return bands;
}

function broadOf(bands: readonly Band[]): Peak[] {
  const level = bands.map(({ density }) => density);
  return bands.slice(1, -1).flatMap((band, i): Peak[] => {
    const k = i + 1;
    const own = band.density;
    if (!(at(level, k - 1) < own && own >= at(level, k + 1))) return [];
    const [left, right] = around(level, k, (each) => each > own);
    const valley = Math.max(
      Math.min(own, ...level.slice(left, k)),
      Math.min(own, ...level.slice(k + 1, right)),
    );
    if (own < PROMINENT * valley) return [];
    const [first, stop] = around(level, k, (each) => each < 0.5 * own);
    const power = bands
      .slice(first, stop)
      .reduce((total, { density, width }) => total + density * width, 0);
    const [before, after] = [bands[k - 1], bands[k + 1]] as [Band, Band];
    const step = Math.log(after.frequency / before.frequency) / 2;
    const place = band.frequency * Math.exp(step * vertex(before.density, own, after.density));
    return [{ frequency: place, density: own, rms: Math.sqrt(power), narrow: false }];
  });
}

/** The stretch about one of some values up to the next on either side for which something holds. */
function around(
  values: readonly number[],
  k: number,
  holds: (value: number) => boolean,
): [first: number, stop: number] {
  const right = values.findIndex((value, i) => i > k && holds(value));
  let left = k;
  while (left > 0 && !holds(at(values, left - 1))) left -= 1;
  return [left, right < 0 ? values.length : right];
}

function halfEven(value: number): number {
  const rounded = Math.round(value);
  return Math.abs(value % 1) === 0.5 && rounded % 2 !== 0 ? rounded - 1 : rounded;
}

export function at(values: ArrayLike<number>, k: number): number {
  return values[k] as number;
}
