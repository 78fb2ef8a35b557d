/** A spectrum as a plot and a table: curves of each column, the response of its loop, its peaks. */

import type { Look, Mark, PlotAxis, Series } from '../../plot/types';
import { scopeOf, unitsOf } from '../../plot/scope-catalog';
import { scopeWith } from '../../plot/scope-layout';
import type { Channel } from '../../plot/source';
import { digits, scaleFor } from '../../ui/units';
import type { components } from '../../app/api/schema';

export type SpectrumDocument = components['schemas']['SpectrumDocument'];
export type ColumnSpectrum = components['schemas']['ColumnSpectrum'];
export type WindowName = SpectrumDocument['window'];
type Peak = components['schemas']['SpectrumPeak'];

/** How a spectrum is taken, and which frequencies of it; without ends all of them. */
export interface SpectrumSettings {
  window: WindowName;
  averages: number;
  low?: number;
  high?: number;
}

export type SpectrumView = 'amplitude' | 'density' | 'cumulative';

export const VIEWS = [
  { value: 'amplitude', name: 'Amplitude', title: 'Peak value of a sine at each frequency' },
  { value: 'density', name: 'Density', title: 'Root of the power spectral density' },
  { value: 'cumulative', name: 'RMS below', title: 'RMS of all at a frequency and below' },
] as const satisfies readonly { value: SpectrumView; name: string; title: string }[];

export const WINDOWS: readonly { value: WindowName; name: string }[] = [
  { value: 'hann', name: 'Hann' },
  { value: 'rectangular', name: 'rectangular' },
  { value: 'blackman-harris', name: 'Blackman-Harris' },
  { value: 'flat-top', name: 'flat top' },
];

export const AVERAGES = [1, 2, 4, 8, 16, 32, 64] as const;

/** Peaks of a column that are named in the plot. */
const NAMED = 3;

const KINDS: Record<Peak['kind'], string> = { line: 'line', broad: 'broad', loop: 'loop’s own' };

/** Name and colours of each column among the others, as scopes have them. */
export type Named = ReadonlyMap<string, Pick<Look, 'ink' | 'dash'> & { label: string }>;

/** Columns of one unit, which share a plot. */
export interface SpectrumPlot {
  title: string;
  columns: readonly ColumnSpectrum[];
}

/** Returns the plots of some columns: one for each unit. */
export function plotsOf(columns: readonly ColumnSpectrum[]): SpectrumPlot[] {
  const units = [...new Set(columns.map(({ unit }) => unit))];
  return units.map((unit) => {
    const own = columns.filter((column) => column.unit === unit);
    const { title } = scopeOf(scopeWith(...own.map(({ name }) => name)), new Map());
    return { title: `Spectrum of ${title.charAt(0).toLowerCase()}${title.slice(1)}`, columns: own };
  });
}

export function namesOf(channels: readonly Channel[]): Named {
  const { all } = scopeOf(scopeWith(...channels.map(({ name }) => name)), unitsOf(channels));
  return new Map(all.map(({ column, ...look }) => [column, look]));
}

const named = (names: Named, { name }: Pick<ColumnSpectrum, 'name'>) =>
  names.get(name) ?? { label: name, ink: 'reference' as const };

/** What a view draws of a density, unit²/Hz. */
function drawn(view: SpectrumView, column: ColumnSpectrum): (density: number) => number {
  return view === 'density'
    ? Math.sqrt
    : (density) => Math.sqrt(2 * density * column.noise_bandwidth);
}

function values(view: SpectrumView, column: ColumnSpectrum): number[] {
  return view === 'density' ? column.density.map(Math.sqrt) : column[view];
}

/** The value axis: one prefix for all columns. */
export function valueAxis(view: SpectrumView, columns: readonly ColumnSpectrum[]): PlotAxis {
  const unit = columns[0]?.unit ?? '1';
  const shown = columns.flatMap((column) => values(view, column)).filter((value) => value > 0);
  const [low, high] = shown.reduce(
    ([least, most], value) => [Math.min(least, value), Math.max(most, value)],
    [Infinity, 0],
  );
  const { factor, unit: prefixed } = scaleFor(Math.sqrt(low * high), unit);
  const label = VIEWS.find(({ value }) => value === view)?.name.toLowerCase() ?? '';
  const scale = { factor, unit: view === 'density' ? `${prefixed}/√Hz` : prefixed };
  return { label, unit, scale, log: true };
}

/** Curves of all columns, dashed what their loops make of a white disturbance. */
export function spectrumSeries(
  view: SpectrumView,
  columns: readonly ColumnSpectrum[],
  names: Named,
): Series[] {
  return columns.flatMap((column) => {
    const { label: name, ink = 'reference', dash = 'solid' } = named(names, column);
    const curve: Series = {
      name,
      x: column.frequency,
      y: values(view, column),
      ink,
      dash,
      width: 1.2,
    };
    if (view === 'cumulative') return [curve];
    const level = drawn(view, column);
    const { loop } = column;
    const response: Series[] = loop
      ? [
          {
            name: `loop of ${name}`,
            x: loop.frequency,
            y: loop.density.map(level),
            ink,
            dash: 'dash',
            width: 2,
          },
        ]
      : [];
    return [curve, ...response];
  });
}

/** The strongest peaks of each column, named by their frequency. */
export function peakMarks(columns: readonly ColumnSpectrum[], names: Named): Mark[] {
  return columns.flatMap((column) => {
    const { label, ink = 'reference' } = named(names, column);
    return [...column.peaks]
      .sort((a, b) => b.rms - a.rms)
      .slice(0, NAMED)
      .map(({ frequency }) => ({
        axis: 'x' as const,
        at: frequency,
        label: `${label} ${digits(frequency, 4)} Hz`,
        ink,
        dash: 'dot' as const,
      }));
  });
}

export interface PeakRow {
  key: string;
  name: string;
  /** The variant whose colour it has; empty for none. */
  variant: string;
  frequency: number;
  kind: string;
  /** Amplitude, RMS and dB above the loop; a dash where there is none. */
  cells: string[];
}

/** The table of peaks, those of one quantity in one unit. */
export function peakRows(columns: readonly ColumnSpectrum[], names: Named): PeakRow[] {
  return columns.flatMap((column) => {
    const same = columns.filter(({ unit }) => unit === column.unit);
    const largest = Math.max(0, ...same.flatMap(({ peaks }) => peaks.map(({ rms }) => rms)));
    const { factor, unit } = scaleFor(largest, column.unit);
    const text = (value: number | null) =>
      value === null ? '–' : `${digits(value * factor)} ${unit}`;
    return column.peaks.map(({ frequency, kind, amplitude, rms, above_loop: above }) => ({
      key: `${column.name} ${frequency}`,
      name: named(names, column).label,
      variant: /^([A-Z])\./.exec(column.name)?.[1] ?? '',
      frequency,
      kind: KINDS[kind],
      cells: [text(amplitude), text(rms), above === null ? '–' : above.toFixed(1)],
    }));
  });
}

/** What is to know about a column: its stretch, what a bin is, and how its loop's level came about. */
export function facts(column: ColumnSpectrum, period: number, names: Named): string {
  const { start, stop, missing, resolution, noise_bandwidth, rms, unit, loop } = column;
  const of = scaleFor(rms, unit);
  const parts = [
    `${named(names, column).label}: RMS ${digits(rms * of.factor)} ${of.unit}`,
    `${digits(start * period, 4)} to ${digits(stop * period, 4)} s`,
    `resolution ${digits(resolution)} Hz`,
    `noise bandwidth ${digits(noise_bandwidth)} Hz`,
  ];
  if (missing > 0) {
    parts.push(`the longest stretch without a missing sample, ${missing} left out`);
  }
  if (!loop) return parts.join(', ');
  const speed = `${digits(1e3 * loop.velocity)} mm/s`;
  const force = scaleFor(loop.force, 'N');
  parts.push(
    `loop linearised about ${speed}, its level fitted: ${digits(loop.force * force.factor)} ${force.unit}/√Hz on the thrust`,
  );
  return parts.join(', ');
}

/** Frequencies around one that is looked at, or nearer and farther by a ratio. */
export function zoomed(
  { low, high }: { low: number; high: number },
  ratio: number,
  centre: number,
  bounds: { low: number; high: number },
): { low: number; high: number } | null {
  const at = Math.min(high, Math.max(low, centre));
  const from = Math.max(bounds.low, at * (low / at) ** ratio);
  const to = Math.min(bounds.high, at * (high / at) ** ratio);
  if (from <= bounds.low * 1.001 && to >= bounds.high * 0.999) return null;
  return to / from > NARROWEST ? { low: from, high: to } : { low, high };
}

const NARROWEST = 1.01;
