/** Margins as text, and whether they hold their limits. */

import { digits } from '../../ui/units';
import type { LoopAt, LoopFigures } from './loops.svelte';
import type { MarginName } from './margin-limits.svelte';

/** A gain margin in decibels; one that is infinite, because nothing crosses, as such. */
export function inDecibels(factor: number | null): string {
  return factor === null ? '∞' : digits(20 * Math.log10(factor));
}

export function inDegrees(rad: number | null): string {
  return rad === null ? '–' : digits((rad * 180) / Math.PI);
}

export interface MarginCell {
  name: MarginName;
  /** Where it is so: `at standstill`, or `sliding at 174 mm/s`. */
  place: string;
  /** Of two of one name the larger is the worse margin. */
  badness: number;
  /** Its term in the glossary. */
  term: 'GM' | 'PM' | 'M_s';
  text: string;
  unit: string;
  /** Of a track that a full margin fills, from 0 to 1. */
  share: number;
  /** The limit on that track; null where there is none. */
  limitShare: number | null;
  /** The limit as text: `at least 6 dB`; empty where there is none. */
  limitText: string;
  holds: boolean;
}

const clamp = (value: number) => Math.min(1, Math.max(0, value));

/** The smaller of the factors by which the loop's gain may grow or fall, as a factor above 1. */
export function leastGainMargin({ gain_margin, gain_reduction }: LoopAt): number | null {
  const both = [gain_margin, gain_reduction === null ? null : 1 / gain_reduction];
  const known = both.filter((factor) => factor !== null);
  return known.length > 0 ? Math.min(...known) : null;
}

/** Where an axis is: stuck, or sliding at a velocity. */
export function placeOf({ velocity }: LoopAt): string {
  return velocity === 0 ? 'at standstill' : `sliding at ${digits(velocity * 1e3)} mm/s`;
}

/** Where a loop is unstable; empty where it is stable while it slides and at standstill. */
export function instability(figures: LoopFigures): string {
  const places = [figures, figures.standstill].filter(({ stable }) => !stable);
  return places.length === 2 ? 'sliding and at standstill' : places.map(placeOf).join('');
}

/**
 * Returns gain margin, phase margin and M_s of a stable loop, each the worse of sliding and
 * standstill, against its limit.
 */
export function marginCells(
  figures: LoopFigures,
  limit: (name: MarginName) => number | null,
): MarginCell[] {
  const sliding = cellsAt(figures, limit);
  return cellsAt(figures.standstill, limit).map((cell, i) => {
    const other = sliding[i];
    return other && other.badness >= cell.badness ? other : cell;
  });
}

function cellsAt(figures: LoopAt, limit: (name: MarginName) => number | null): MarginCell[] {
  const decibels = (factor: number | null) =>
    factor === null ? Infinity : 20 * Math.log10(factor);
  const degrees = (rad: number) => (rad * 180) / Math.PI;
  const gain = leastGainMargin(figures);
  const { phase_margin, Ms } = figures;
  const place = placeOf(figures);
  const [least, phase, most] = [limit('gain_margin'), limit('phase_margin'), limit('Ms')];
  return [
    {
      name: 'gain_margin',
      place,
      badness: gain === null ? 0 : 1 / gain,
      term: 'GM',
      text: inDecibels(gain),
      unit: 'dB',
      share: clamp(decibels(gain) / 18),
      limitShare: least === null ? null : clamp(decibels(least) / 18),
      limitText: least === null ? '' : `at least ${inDecibels(least)} dB`,
      holds: least === null || gain === null || gain >= least,
    },
    {
      name: 'phase_margin',
      place,
      badness: phase_margin === null ? -Infinity : -phase_margin,
      term: 'PM',
      text: inDegrees(phase_margin),
      unit: '°',
      share: phase_margin === null ? 1 : clamp(degrees(phase_margin) / 90),
      limitShare: phase === null ? null : clamp(degrees(phase) / 90),
      limitText: phase === null ? '' : `at least ${inDegrees(phase)}°`,
      holds: phase === null || phase_margin === null || phase_margin >= phase,
    },
    {
      name: 'Ms',
      place,
      badness: Ms,
      term: 'M_s',
      text: digits(Ms),
      unit: '',
      share: clamp((Ms - 1) / 3),
      limitShare: most === null ? null : clamp((most - 1) / 3),
      limitText: most === null ? '' : `at most ${digits(most)}`,
      holds: most === null || Ms <= most,
    },
  ];
}
