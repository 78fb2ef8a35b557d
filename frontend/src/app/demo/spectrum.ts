/**
 * The answer to POST /spectrum, computed in the page: Welch's density and its peaks, as
 * analysis/spectrum.py defines them. The response of the loop is a server's.
 */

import type { components } from '../api/schema';
import { PowerTransform } from './fourier';
import { at, peaksOf, type Spectrum } from './spectral-peaks';

type Document = components['schemas']['SpectrumDocument'];
type Column = components['schemas']['ColumnSpectrum'];
type WindowName = Document['window'];

/** What the Lab asks; scenario and changes are of a loop, which is not looked at. */
export interface SpectrumRequest {
  period: number;
  columns: { name: string; unit: string; values: (number | null)[] }[];
  window?: WindowName;
  averages?: number;
  low?: number | null;
  high?: number | null;
  points?: number;
}

/** Coefficients of the cosines of each window, whose signs alternate. */
const COSINES: Record<WindowName, readonly number[]> = {
  rectangular: [1],
  hann: [0.5, 0.5],
  'blackman-harris': [0.35875, 0.48829, 0.14128, 0.01168],
  'flat-top': [0.21557895, 0.41663158, 0.277263158, 0.083578947, 0.006947368],
};
const SEGMENT_LEAST = 64;
const NOTE = 'a demo does not linearise it, a server does';

/** @throws Error where there are too few samples, or no bin in the range */
export function spectrumDocument(request: SpectrumRequest): Document {
  const { period, window = 'hann', averages = 8 } = request;
  const columns = request.columns.map((column): Column => {
    const [start, stop] = longestWhole(column.values);
    const values = Float64Array.from(column.values.slice(start, stop) as number[]);
    const spectrum = spectrumOf(values, period, window, averages);
    const { density, amplitude, resolution } = spectrum;
    const shown = binsOf(spectrum, request);
    const sums = density.slice();
    for (let k = 1; k < sums.length; k++) (sums[k] as number) += sums[k - 1] as number;
    const total = sums[sums.length - 1] as number;
    const below = (k: number) => (total > 0 ? spectrum.rms * Math.sqrt(at(sums, k) / total) : 0);
    return {
      name: column.name,
      unit: column.unit,
      start,
      stop,
      missing: column.values.length - (stop - start),
      resolution,
      noise_bandwidth: spectrum.noiseBandwidth,
      bins: density.length,
      rms: spectrum.rms,
      frequency: shown.map((k) => figures(resolution * (k + 1))),
      density: shown.map((k) => figures(at(density, k))),
      amplitude: shown.map((k) => figures(at(amplitude, k))),
      cumulative: shown.map((k) => figures(below(k))),
      peaks: peaksOf(spectrum, COSINES[window].length, averages).map(({ narrow, ...peak }) => ({
        ...peak,
        kind: narrow ? 'line' : 'broad',
        amplitude: narrow ? Math.SQRT2 * peak.rms : null,
        above_loop: null,
      })),
      loop: null,
      note: NOTE,
    };
  });
  return { period, window, averages, columns };
}

function longestWhole(values: readonly (number | null)[]): [start: number, stop: number] {
  let best: [number, number] = [0, 0];
  let start = 0;
  for (let i = 0; i <= values.length; i++) {
    if (i < values.length && values[i] !== null) continue;
    if (i - start > best[1] - best[0]) best = [start, i];
    start = i + 1;
  }
  return best;
}

function spectrumOf(
  samples: Float64Array,
  period: number,
  window: WindowName,
  averages: number,
): Spectrum {
  const count = samples.length;
  const segment = averages === 1 ? count : smooth(2 * Math.floor(count / (averages + 1)));
  if (segment < SEGMENT_LEAST) {
    throw new Error(`A segment has ${segment} samples, and needs ${SEGMENT_LEAST}.`);
  }
  const mean = sum(samples) / count;
  const values = samples.map((value) => value - mean);
  const weight = Float64Array.from({ length: segment }, (_, i) =>
    COSINES[window].reduce(
      (total, a, k) => total + (k % 2 ? -a : a) * Math.cos((2 * Math.PI * k * i) / segment),
      0,
    ),
  );
  const transform = new PowerTransform(segment);
  const power = new Float64Array(Math.floor(segment / 2));
  for (let k = 0; k < averages; k++) {
    const first = Math.floor((k * segment) / 2);
    const part = values.subarray(first, first + segment);
    const bins = transform.of(part.map((value, i) => value * at(weight, i)));
    for (let i = 0; i < power.length; i++) (power[i] as number) += (2 * at(bins, i + 1)) / averages;
  }
  const area = sum(weight);
  const energy = sum(weight.map((value) => value ** 2));
  const amplitude = power.map((each) => Math.sqrt(2 * each) / area);
  if (segment % 2 === 0) {
    // Half the rate has no image at a negative frequency.
    (power[power.length - 1] as number) /= 2;
    (amplitude[power.length - 1] as number) /= 2;
  }
  return {
    density: power.map((each) => (each * period) / energy),
    amplitude,
    rms: Math.sqrt(sum(values.map((value) => value ** 2)) / count),
    segment,
    resolution: 1 / (segment * period),
    noiseBandwidth: energy / (period * area ** 2),
  };
}

/** The largest even number up to a count without a prime factor above 5, as the server takes it. */
function smooth(count: number): number {
  for (let even = count - (count % 2); even > SEGMENT_LEAST; even -= 2) {
    let rest = even;
    for (const factor of [2, 3, 5]) while (rest % factor === 0) rest /= factor;
    if (rest === 1) return even;
  }
  return count;
}

/** The bins to draw: least and largest of equal steps of the logarithm of frequency. */
function binsOf({ density: S, resolution }: Spectrum, request: SpectrumRequest): number[] {
  const { low, high, points = 2000 } = request;
  const bins = [...S.keys()].filter((k) => {
    const frequency = resolution * (k + 1);
    return frequency >= (low ?? 0) && frequency <= (high ?? Number.POSITIVE_INFINITY);
  });
  const [first, last] = [bins[0], bins.at(-1)];
  if (first === undefined || last === undefined) {
    throw new Error('There is no bin between the least and the largest frequency.');
  }
  if (bins.length <= points) return bins;
  const steps = Math.max(1, Math.floor(points / 2));
  const stepOf = (k: number) =>
    Math.floor((steps * Math.log((k + 1) / (first + 1))) / Math.log((last + 1) / (first + 1)));
  const least = new Map<number, number>();
  const most = new Map<number, number>();
  for (const k of bins) {
    const step = Math.min(stepOf(k), steps - 1);
    if (at(S, k) < at(S, least.get(step) ?? k) || !least.has(step)) least.set(step, k);
    if (at(S, k) > at(S, most.get(step) ?? k) || !most.has(step)) most.set(step, k);
  }
  return [...new Set([...least.values(), ...most.values()])].sort((a, b) => a - b);
}

function sum(values: Float64Array): number {
  return values.reduce((total, value) => total + value, 0);
}

function figures(value: number): number {
  return Number(value.toPrecision(6));
}
