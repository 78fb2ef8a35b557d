/** Sets of gains side by side: the present ones, the paper's, what the simplex found, what is picked. */

import type {
  Axis,
  Candidate,
  Changes,
  SafeTune,
  ShapedLoop,
  TuneGroup,
  TunedAxis,
} from '../../app/api/types';
import { digits } from '../../ui/units';

/** Verdict on a set of gains; null if it was not tried. */
export type Verdict = Pick<Candidate, 'cost' | 'feasible' | 'violations'>;

/** The worst of a quantity over the motors, and on which motor that is. */
export interface Worst {
  /** SI; null where it diverged. */
  value: number | null;
  motor: string;
  /** Sliding velocity at which a margin is worst, m/s. */
  velocity: number | null;
}

export interface CandidateLine {
  /** Identifies the line within its group. */
  id: string;
  name: string;
  /** Gains of the axis that is looked at. */
  k_p: number;
  k_d: number;
  /** Largest and root mean square error, m; null of what was not tried. */
  peak: Worst | null;
  rms: Worst | null;
  /** Whether the loop is so on every motor, at every sliding velocity; null without a loop. */
  stable: boolean | null;
  /** Null where nothing crosses. */
  gainMargin: Worst | null;
  /** rad */
  phaseMargin: Worst | null;
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

function largest({ metrics }: TunedAxis, metric: 'peak' | 'rms'): Worst | null {
  const all = Object.entries(metrics).map(([motor, one]) => ({
    value: one[metric],
    motor,
    velocity: null,
  }));
  const away = all.find(({ value }) => value === null);
  return away ?? all.sort((a, b) => (b.value ?? 0) - (a.value ?? 0))[0] ?? null;
}

function least({ margins }: TunedAxis, margin: 'gain_margin' | 'phase_margin'): Worst | null {
  const all = Object.entries(margins).flatMap(([motor, one]) => {
    const worst = one[margin];
    return worst ? [{ ...worst, motor }] : [];
  });
  return all.sort((a, b) => a.value - b.value)[0] ?? null;
}

function isStable({ margins }: TunedAxis): boolean | null {
  const all = Object.values(margins);
  return all.length > 0 ? all.every(({ stable }) => stable) : null;
}

export function idOf({ origin, start }: Candidate): string {
  return start === null ? origin : `start ${start.toString()}`;
}

function lineOf(candidate: Candidate, axis: Axis): CandidateLine | null {
  const tuned = candidate.axes[axis];
  if (!tuned) return null;
  const stable = isStable(tuned);
  const id = idOf(candidate);
  return {
    id,
    name: id,
    k_p: tuned.k_p,
    k_d: tuned.k_d,
    peak: largest(tuned, 'peak'),
    rms: largest(tuned, 'rms'),
    stable,
    gainMargin: stable ? least(tuned, 'gain_margin') : null,
    phaseMargin: stable ? least(tuned, 'phase_margin') : null,
    cost: candidate.cost,
    verdict: candidate,
    set: candidate.set,
  };
}

/** Names chosen lines in short: `x 2, y paper`. */
export function choiceText(chosen: readonly { axis: Axis; id: string }[]): string {
  return chosen.map(({ axis, id }) => `${axis} ${id.replace(/^start /, '')}`).join(', ');
}

/** Returns the lines of the group that an axis belongs to; the best candidate follows the paper's. */
export function linesOf(groups: readonly TuneGroup[], axis: Axis): CandidateLine[] {
  const group = groups.find(({ axes }) => axes.includes(axis));
  if (!group) return [];
  return [group.present, group.paper, ...group.candidates].flatMap((candidate) => {
    const line = lineOf(candidate, axis);
    return line ? [line] : [];
  });
}

/** Returns the line of gains that were picked off the landscape. */
export function pickedLine({ k_p, k_d, cost }: Picked, variant: string, axis: Axis): CandidateLine {
  const path = `variants.${variant}.controller.${axis}`;
  return {
    ...untried(k_p, k_d),
    id: 'picked',
    name: 'picked',
    cost,
    set: { [`${path}.k_p`]: k_p, [`${path}.k_d`]: k_d },
  };
}

/** Returns the line of what was proposed on a measured response. */
export function shapedLine({ after, changes, check }: ShapedLoop): CandidateLine | null {
  const { k_p, k_d } = after;
  if (
    check?.holds === false ||
    Object.keys(changes).length === 0 ||
    k_p === undefined ||
    k_d === undefined
  )
    return null;
  return {
    ...untried(k_p, k_d),
    id: 'shaped',
    name: 'shaped',
    set: changes as Changes,
  };
}

/** Returns the lines of gains that are proposed for a machine, and of the best ones on it. */
export function machineLines(
  { proposal, motions, best, changes }: SafeTune,
  metric: 'peak' | 'rms',
): CandidateLine[] {
  const made = best === null ? undefined : motions[best];
  const lines: CandidateLine[] = [];
  if (proposal && Object.keys(proposal.changes).length > 0) {
    const set = proposal.changes as Changes;
    lines.push({ ...untried(proposal.k_p, proposal.k_d), id: 'next', name: 'next', set });
  }
  if (made && Object.keys(changes).length > 0) {
    // A rehearsal's motions are no runs.
    const name = made.run === null ? 'best rehearsed' : 'best on the machine';
    const measured = { value: made.metric, motor: 'the machine', velocity: null };
    lines.push({
      ...untried(made.k_p, made.k_d),
      id: name,
      name,
      [metric]: measured,
      set: changes as Changes,
    });
  }
  return lines;
}

/** What a line has whose motion was not tried. */
function untried(k_p: number, k_d: number) {
  return {
    k_p,
    k_d,
    peak: null,
    rms: null,
    stable: null,
    gainMargin: null,
    phaseMargin: null,
    cost: null,
    verdict: null,
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

/** Where a quantity is worst: `matched`, or `matched at 17.6 mm/s`. */
export function placeOf({ motor, velocity }: Worst): string {
  if (velocity === null) return motor;
  return `${motor} at ${velocity === 0 ? 'standstill' : `${digits(velocity * 1e3)} mm/s`}`;
}

/** Says on which motor each quantity of a line is worst. */
export function placesOf({ peak, rms, gainMargin, phaseMargin }: CandidateLine): string {
  const worst = Object.entries({ peak, rms, GM: gainMargin, PM: phaseMargin });
  return worst
    .flatMap(([name, margin]) => (margin ? [`${name} ${placeOf(margin)}`] : []))
    .join(', ');
}
