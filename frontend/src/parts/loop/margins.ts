/** Margins as text, and whether they hold their limits. */

import { decibels, degrees, digits } from '../../ui/units';
import type { LoopOfAxis } from '../../kernel/loops';
import type { MarginName } from './loops.svelte';

/** A gain margin in decibels; one that is infinite, because nothing crosses, as such. */
export function inDecibels(factor: number | null): string {
  return factor === null ? '∞' : digits(decibels(factor));
}

export function inDegrees(rad: number | null): string {
  return rad === null ? '–' : digits(degrees(rad));
}

export interface MarginCell {
  name: MarginName;
  /** Where it is so: `at standstill`, or `sliding at 174 mm/s`. */
  place: string;
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
  /** How far it is from its limit, as a share of that: below zero beyond it, infinite without one. */
  reserve: number;
  /** Whether it holds its limit well, only just, or not. */
  state: 'good' | 'warn' | 'bad';
}

/** A margin with less in reserve than this share of its limit holds only just. */
const CLOSE = 0.1;

function judged(reserve: number): Pick<MarginCell, 'holds' | 'reserve' | 'state'> {
  return {
    holds: reserve >= 0,
    reserve,
    state: reserve < 0 ? 'bad' : reserve < CLOSE ? 'warn' : 'good',
  };
}

/** What is in reserve of a value that may not be less than its least; both in the unit that is read. */
function above(value: number | null, least: number | null): number {
  return value === null || least === null ? Number.POSITIVE_INFINITY : value / least - 1;
}

const clamp = (value: number) => Math.min(1, Math.max(0, value));

/** Where an axis is: stuck, or sliding at a velocity. */
function placeOf(velocity: number): string {
  return velocity === 0 ? 'at standstill' : `sliding at ${digits(velocity * 1e3)} mm/s`;
}

/** Where a loop is unstable; empty where it is stable at standstill and at every velocity. */
export function instability({ stable, standstill, worst }: LoopOfAxis): string {
  // With a velocity it would be too long for its line.
  if (!stable && !standstill.stable) return 'sliding and at standstill';
  return worst.stable ? '' : placeOf(worst.velocity);
}

/**
 * Returns gain margin, phase margin and M_s of a stable loop against their limits: the worst at
 * standstill and while sliding, as tuning and explanations judge them.
 */
export function marginCells(
  { worst }: LoopOfAxis,
  limit: (name: MarginName) => number | null,
): MarginCell[] {
  const gain = worst.gain_margin?.value ?? null;
  const phase = worst.phase_margin?.value ?? null;
  const Ms = worst.Ms?.value ?? null;
  const [least, angle, most] = [limit('gain_margin'), limit('phase_margin'), limit('Ms')];
  const place = (name: MarginName) => {
    const at = worst[name];
    return at ? placeOf(at.velocity) : 'nowhere';
  };
  return [
    {
      name: 'gain_margin',
      place: place('gain_margin'),
      term: 'GM',
      text: inDecibels(gain),
      unit: 'dB',
      share: gain === null ? 1 : clamp(decibels(gain) / 18),
      limitShare: least === null ? null : clamp(decibels(least) / 18),
      limitText: least === null ? '' : `at least ${inDecibels(least)} dB`,
      ...judged(above(gain && decibels(gain), least && decibels(least))),
    },
    {
      name: 'phase_margin',
      place: place('phase_margin'),
      term: 'PM',
      text: inDegrees(phase),
      unit: '°',
      share: phase === null ? 1 : clamp(degrees(phase) / 90),
      limitShare: angle === null ? null : clamp(degrees(angle) / 90),
      limitText: angle === null ? '' : `at least ${inDegrees(angle)}°`,
      ...judged(above(phase, angle)),
    },
    {
      name: 'Ms',
      place: place('Ms'),
      term: 'M_s',
      text: Ms === null ? '∞' : digits(Ms),
      unit: '',
      share: Ms === null ? 1 : clamp((Ms - 1) / 3),
      limitShare: most === null ? null : clamp((most - 1) / 3),
      limitText: most === null ? '' : `at most ${digits(most)}`,
      ...judged(most === null ? Number.POSITIVE_INFINITY : Ms === null ? -1 : 1 - Ms / most),
    },
  ];
}
