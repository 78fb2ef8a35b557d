/** The server's answer to POST /trajectories/check: what a path asks of the motor. */

import { readCurves } from '../../app/api/curves-answer';
import { AXES, type Axis, type Trajectory } from '../../app/api/types';
import type { Envelope } from '../../plot/source';
import type { Outline } from './geometry';
import { digits, inScale, quantity } from '../../ui/units';

export type Limited = 'position' | 'step' | 'velocity' | 'acceleration' | 'thrust';

/** Bit k of the column `violated` stands for the k-th of these. */
export const QUANTITIES: readonly Limited[] = [
  'position',
  'step',
  'velocity',
  'acceleration',
  'thrust',
];

export interface Violation {
  quantity: Limited;
  axis: Axis;
  start: number;
  end: number;
  time: number;
  place: [number, number];
  value: number;
  limit: number;
  unit: string;
}

export interface Peak {
  quantity: Limited;
  axis: Axis;
  value: number;
  limit: number | null;
  share: number | null;
  unit: string;
}

interface Head {
  feasible: boolean;
  duration: number;
  examined: number;
  length: number;
  /** Least and largest position of every tick, m; the columns have those at the start of bins. */
  extent: Record<Axis, [least: number, most: number]>;
  time: { start: number; step: number; count: number };
  peaks: Peak[];
  violations: Violation[];
  violation_count: number;
  /** What a user must know of the motion, such as that a faster one may exist. */
  notes: string[];
  /** Share of the thrust that its limit leaves to feedback. */
  thrust_reserve: number;
  /** A figure as a path whose points can be dragged; null for what has no corners. */
  drawn: Trajectory | null;
}

export interface Checked extends Head {
  columns: Map<string, Envelope>;
  /** The curve of a smooth path. */
  outline: Outline | null;
}

/** Reads an answer; the curves are views into it. */
export function readChecked(buffer: ArrayBuffer): Checked {
  type Indices = Record<'x' | 'y' | 'edge' | 'count', number>;
  const { numbers, outline, ...head } = readCurves<Head & { outline: Indices | null }>(buffer);
  const column = (from: number) => numbers.subarray(from, from + (outline?.count ?? 0));
  return {
    ...head,
    outline: outline && {
      x: column(outline.x),
      y: column(outline.y),
      edge: column(outline.edge),
    },
  };
}

/** Returns the stretches [from, to) of bins in which any of some quantities is too large. */
export function stretches(
  { columns }: Pick<Checked, 'columns'>,
  quantities: readonly Limited[] = QUANTITIES,
): [number, number][] {
  const flags = columns.get('violated')?.maximum;
  if (!flags) return [];
  const mask = quantities.reduce((sum, each) => sum | (1 << QUANTITIES.indexOf(each)), 0);
  const stretchesOfBins: [number, number][] = [];
  let from = -1;
  for (let i = 0; i <= flags.length; i++) {
    const bad = i < flags.length && ((flags[i] as number) & mask) !== 0;
    if (bad && from < 0) from = i;
    if (!bad && from >= 0) {
      stretchesOfBins.push([from, i]);
      from = -1;
    }
  }
  return stretchesOfBins;
}

interface Variant {
  diverged: unknown;
  axes: Partial<Record<Axis, { saturated_fraction?: number | null }>>;
}

/** Returns a sentence on each variant that is at a limit some of the time, or that diverges. */
export function atLimits(variants: Readonly<Record<string, Variant>>): string[] {
  return Object.entries(variants).flatMap(([name, { diverged, axes }]) => {
    if (diverged) return [`${name} diverges on this path.`];
    const shares = AXES.flatMap((axis) => {
      const share = axes[axis]?.saturated_fraction ?? 0;
      return share > 0 ? [`${digits(share * 100, 2)} % of the time on ${axis}`] : [];
    });
    return shares.length > 0
      ? [`${name} has its command or currents at a limit ${shares.join(', ')}.`]
      : [];
  });
}

const NAMES: Record<Limited, string> = {
  position: 'leaves the stroke',
  step: 'jumps',
  velocity: 'too fast',
  acceleration: 'accelerates too hard',
  thrust: 'needs too much thrust',
};

/** Names what is wrong: "x leaves the stroke". */
export function title({ quantity, axis }: Violation): string {
  return `${axis} ${NAMES[quantity]}`;
}

/** Gives the value against what is allowed. */
export function amount({ value, limit, unit }: Violation): string {
  return `${withUnit(value, unit)}, allowed ±${withUnit(limit, unit)}`;
}

export function placeText([x, y]: readonly [number, number]): string {
  return `x ${mm(x)}, y ${mm(y)} mm`;
}

export function timeText({ start, end }: Violation): string {
  const [from, to] = [digits3(start), digits3(end)];
  return from === to ? `at ${from} s` : `${from} to ${to} s`;
}

function mm(value: number): string {
  const text = (value * 1e3).toFixed(2);
  return text === '-0.00' ? '0.00' : text.replace('-', '−');
}

function digits3(seconds: number): string {
  return seconds === 0 ? '0' : digits(seconds, seconds < 10 ? 3 : 4);
}

/** Formats an SI value with its unit as one text; accelerations in m/s², as on the whole screen. */
export function withUnit(value: number | null | undefined, unit: string): string {
  if (unit === 'm/s^2' && typeof value === 'number') {
    return `${inScale(value, { factor: 1, unit: 'm/s²' })} m/s²`;
  }
  const { number, unit: shown } = quantity(value, unit);
  return shown === '' ? number : `${number} ${shown}`;
}
