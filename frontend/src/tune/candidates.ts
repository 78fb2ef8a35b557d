/** Sets of gains side by side: the present ones, the paper's, what the simplex found, what is picked. */

import type { Axis, Candidate, Changes, TuneGroup } from '../api/types';
import { digits } from '../units';

/** What is thought of a set of gains; null of one that was not tried. */
export type Verdict = Pick<Candidate, 'cost' | 'feasible' | 'violations'>;

export interface Line {
  /** Identifies the line within its group. */
  id: string;
  name: string;
  /** Gains of the axis that is looked at. */
  k_p: number;
  k_d: number;
  /** Largest and root mean square error on the worst motor, m; null where it ran away. */
  peak: number | null;
  rms: number | null;
  /** N */
  effort: number | null;
  gainMargin: number | null;
  /** rad */
  phaseMargin: number | null;
  cost: number | null;
  verdict: Verdict | null;
  /** What choosing it puts into the scenario. */
  set: Changes;
}

export interface Picked {
  k_p: number;
  k_d: number;
  cost: number | null;
}

function worst(values: readonly (number | null)[]): number | null {
  const known = values.filter((value) => value !== null);
  return known.length < values.length || known.length === 0 ? null : Math.max(...known);
}

export function idOf({ origin, start }: Candidate): string {
  return start === null ? origin : `start ${start.toString()}`;
}

function lineOf(candidate: Candidate, axis: Axis): Line | null {
  const tuned = candidate.axes[axis];
  if (!tuned) return null;
  const metrics = Object.values(tuned.metrics);
  const id = idOf(candidate);
  return {
    id,
    name: id,
    k_p: tuned.k_p,
    k_d: tuned.k_d,
    peak: worst(metrics.map(({ peak }) => peak)),
    rms: worst(metrics.map(({ rms }) => rms)),
    effort: worst(metrics.map(({ effort }) => effort)),
    gainMargin: tuned.margins?.gain_margin ?? null,
    phaseMargin: tuned.margins?.phase_margin ?? null,
    cost: candidate.cost,
    verdict: candidate,
    set: candidate.set,
  };
}

/** Returns the lines of the group that an axis belongs to; the best candidate follows the paper's. */
export function linesOf(groups: readonly TuneGroup[], axis: Axis): Line[] {
  const group = groups.find(({ axes }) => axes.includes(axis));
  if (!group) return [];
  return [group.present, group.paper, ...group.candidates].flatMap((candidate) => {
    const line = lineOf(candidate, axis);
    return line ? [line] : [];
  });
}

/** Returns the line of gains that were picked off the landscape. */
export function pickedLine({ k_p, k_d, cost }: Picked, variant: string, axis: Axis): Line {
  const path = `variants.${variant}.controller.${axis}`;
  return {
    id: 'picked',
    name: 'picked',
    k_p,
    k_d,
    peak: null,
    rms: null,
    effort: null,
    gainMargin: null,
    phaseMargin: null,
    cost,
    verdict: null,
    set: { [`${path}.k_p`]: k_p, [`${path}.k_d`]: k_d },
  };
}

/** The best cost so far over the evaluations of one start; null before one holds the constraints. */
export function bestSoFar(cost: readonly (number | null)[]): (number | null)[] {
  let best: number | null = null;
  return cost.map((value) => {
    if (value !== null && (best === null || value < best)) best = value;
    return best;
  });
}

/** A gain margin in decibels; one that is infinite, because nothing crosses, as such. */
export function inDecibels(factor: number | null): string {
  return factor === null ? '∞' : digits(20 * Math.log10(factor));
}

export function inDegrees(rad: number | null): string {
  return rad === null ? '–' : digits((rad * 180) / Math.PI);
}
