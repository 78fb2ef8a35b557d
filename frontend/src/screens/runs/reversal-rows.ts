/** The quadrant glitches of one axis of a run, as a table: a row a reversal, then the means. */

import type { components } from '../../app/api/schema';
import type { Band, Series } from '../../plot/types';
import { looksOf } from '../../plot/palette';
import { digits, scaleFor } from '../../ui/units';

export type AxisGlitches = components['schemas']['AxisGlitches'];
type Row = components['schemas']['GlitchRow'];
type Aligned = components['schemas']['AlignedError'];
type Mean = components['schemas']['GlitchMean'];

export interface ReversalRow {
  time: number;
  /** "− +" where the axis turns to the positive direction. */
  turn: string;
  /** Of each variant height, delay, rise and duration; empty where there is none. */
  cells: string[][];
}

export interface ReversalTable {
  /** Of each variant the unit of its heights. */
  units: string[];
  rows: ReversalRow[];
  means: string[][];
}

const MILLI = 1e3;

/** Returns the table of some variants, in their order. */
export function reversalTable({ variants }: AxisGlitches, names: readonly string[]): ReversalTable {
  const reversals = names.map((name) => variants[name]);
  const scales = reversals.map((each) =>
    scaleFor(Math.max(0, ...(each?.rows ?? []).map(({ height }) => Math.abs(height))), 'm'),
  );
  const cells = (of: Row | Mean | undefined, k: number) =>
    of === undefined
      ? ['', '', '', '']
      : [
          digits(of.height * (scales[k]?.factor ?? 1)),
          ...[of.delay, of.rise, of.duration].map((time) =>
            time === null ? '–' : (MILLI * time).toFixed(1),
          ),
        ];
  const turns = new Map(
    reversals.flatMap((each) => each?.rows ?? []).map((row) => [row.time, row]),
  );
  const rows = [...turns.values()]
    .sort((a, b) => a.time - b.time)
    .map(({ time, direction }) => ({
      time,
      turn: direction > 0 ? '− +' : '+ −',
      cells: reversals.map((each, k) =>
        cells(
          each?.rows.find((row) => row.time === time),
          k,
        ),
      ),
    }));
  return {
    units: scales.map(({ unit }) => unit),
    rows,
    means: reversals.map((each, k) => cells(each?.mean, k)),
  };
}

/** Says how high the glitch is under each variant. */
export function headline({ variants }: AxisGlitches, names: readonly string[]): string {
  const parts = names.flatMap((name) => {
    const height = variants[name]?.mean.height;
    if (height === undefined) return [];
    const { factor, unit } = scaleFor(height, 'm');
    return [`${digits(height * factor)} ${unit} under ${name}`];
  });
  return `Glitch ${parts.join(', ')}`;
}

/** The mean of all reversals under a variant, a line without markers. */
export function meanSeries(name: string, aligned: Aligned): Series {
  const { ink = 'a', dash = 'solid' } = looksOf(name);
  return { name: 'mean', x: timesOf(aligned), y: aligned.mean, ink, dash };
}

/** All reversals under a variant, from the least to the largest. */
export function spreadBand(name: string, aligned: Aligned): Band {
  const { low, high } = aligned;
  return { name: 'all', x: timesOf(aligned), low, high, ink: looksOf(name).ink ?? 'a' };
}

function timesOf({ start, step, mean }: Aligned): number[] {
  return mean.map((_, i) => start + i * step);
}
