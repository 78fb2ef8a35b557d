/** Laws of force sharing side by side: what is asked, what is drawn, what is compared. */

import type { MapFit, SharingDocument } from '../../../app/api/types';
import { choicesOf } from '../../../app/fields/fields.svelte';
import type { Ink } from '../../../plot/palette';
import type { Dash, Series } from '../../../plot/types';
import { minus } from '../../../ui/units';
import type { Numbers } from '../quantity-fields';

export type Law = SharingDocument['law'];

/** How the curves of each are drawn. */
const STROKES: readonly { dash: Dash; ink: Ink }[] = [
  { dash: 'solid', ink: 'text' },
  { dash: 'dot', ink: 'difference' },
  { dash: 'dash', ink: 'phase-b' },
  { dash: 'dashdot', ink: 'phase-a' },
  { dash: 'long', ink: 'overlay-4' },
];
const LAW = 'variants.A.controller.sharing.law';

/** Every law, as the server has them. */
export const laws = (): Law[] => choicesOf(LAW).map(({ value }) => value as Law);
const strokeOf = (law: Law) => STROKES[Math.max(laws().indexOf(law), 0) % STROKES.length];

/** Name and description of a law. */
export function lawText(law: Law): { name: string; title: string } {
  const choice = choicesOf(LAW).find(({ value }) => value === law);
  return { name: choice?.label ?? law, title: choice?.description ?? '' };
}

/** What the controller believes: the machine's own map, or the analytic one fitted to it. */
export type Belief = 'same' | 'fit';

export interface SharingChoice {
  machines: readonly string[];
  laws: readonly Law[];
  belief: Belief;
}

export interface Run {
  machine: string;
  law: Law;
  answer: SharingDocument;
}

/** Of each machine. */
const WIDTHS = [2.4, 1.2];
/** Ripple over force that only the interpolation of tables leaves. */
const NEGLIGIBLE = 2e-3;
const PHASES = ['a', 'b', 'c'] as const;
const PHASE_DASHES: readonly Dash[] = ['solid', 'dash', 'dot'];

/** The bodies of all requests, machine by machine. */
export function requests(
  { machines, laws, belief }: SharingChoice,
  set: Numbers,
  fits: ReadonlyMap<string, MapFit>,
): { machine: string; law: Law; body: object }[] {
  return machines.flatMap((machine) =>
    laws.map((law) => {
      const fit = belief === 'fit' ? fits.get(machine)?.force_map : undefined;
      const maps = fit ? { controller: fit, plant: machine } : { controller: machine };
      return { machine, law, body: { ...maps, law, ...set } };
    }),
  );
}

export function nameOf(run: Pick<Run, 'machine' | 'law'>, machines: readonly string[]): string {
  const law = lawText(run.law).name;
  return machines.length > 1 ? `${law}, ${run.machine}` : law;
}

type Quantity = 'thrust' | 'reachable' | 'squared_current' | 'normal_force';

/** Whether no law leaves a ripple that could be seen: what is asked is what the plant gives. */
export function smooth(runs: readonly Run[]): boolean {
  return runs.every(
    ({ answer: { thrust } }) => thrust.peak_to_peak <= NEGLIGIBLE * Math.abs(thrust.mean),
  );
}

/** One curve for each run over the share of its pole pitch. */
export function curvesOf(runs: readonly Run[], quantity: Quantity): Series[] {
  const machines = [...new Set(runs.map(({ machine }) => machine))];
  return runs.map((run) => {
    const k = machines.indexOf(run.machine);
    return {
      name: nameOf(run, machines),
      x: places(run),
      y: run.answer.curves[quantity],
      ...strokeOf(run.law),
      width: WIDTHS[k % WIDTHS.length] ?? 1.2,
    };
  });
}

/** The three phases of one run. */
export function phasesOf(run: Run, quantity: 'current' | 'phase_thrust'): Series[] {
  return PHASES.map((phase, k) => ({
    name: phase,
    x: places(run),
    y: run.answer.curves[quantity][k] ?? [],
    ink: `phase-${phase}` as const,
    dash: PHASE_DASHES[k] ?? 'solid',
  }));
}

function places({ answer }: Run): number[] {
  return answer.curves.position.map((position) => position / answer.controller.tau);
}

/** Writes the numbers of a row with as many decimals as its largest takes for four digits. */
export function rowTexts(values: readonly (number | null)[]): string[] {
  const most = Math.max(...values.map((value) => Math.abs(value ?? 0)));
  // A ripple that only interpolation leaves has no more digits to read, and four of them no room.
  const significant = most < 0.1 ? 2 : 4;
  const places = most === 0 ? 0 : significant - 1 - Math.floor(Math.log10(most));
  return values.map((value) =>
    value === null ? '–' : minus(value.toFixed(Math.min(6, Math.max(0, places)))),
  );
}

export interface Row {
  name: string;
  title: string;
  unit: string;
  value: (answer: SharingDocument) => number | null;
}

/** What runs are compared by. */
export const ROWS: readonly Row[] = [
  {
    name: 'mean force',
    title: "Over the pole pitch, on the plant's map",
    unit: 'N',
    value: ({ thrust }) => thrust.mean,
  },
  {
    name: 'ripple p-p',
    title: "Of the total force over the pole pitch, on the plant's map",
    unit: 'N',
    value: ({ thrust }) => thrust.peak_to_peak,
  },
  {
    name: 'ripple/mean',
    title: 'Peak to peak over the mean',
    unit: '%',
    value: ({ thrust }) => (thrust.relative === null ? null : 100 * thrust.relative),
  },
  {
    name: 'ripple rms',
    title: 'Of what the force differs from its mean',
    unit: 'N',
    value: ({ thrust }) => thrust.rms,
  },
  {
    name: 'Σ i², mean',
    title: 'Sum of the three, mean over the pitch: copper loss over the resistance of a phase',
    unit: 'A²',
    value: ({ loss }) => loss.squared_current,
  },
  {
    name: 'copper loss, rel.',
    title: 'Over that of force per ampere on the same map',
    unit: '',
    value: ({ loss }) => loss.relative,
  },
  {
    name: 'normal force, mean',
    title: "Of the three phases over the pole pitch, on the plant's map",
    unit: 'N',
    value: ({ normal_force }) => normal_force.mean,
  },
  {
    name: 'normal force, most',
    title: "Of the three phases at some position, on the plant's map",
    unit: 'N',
    value: ({ normal_force }) => normal_force.largest,
  },
  {
    name: 'reach, least',
    title: 'Command that is carried out at every position',
    unit: 'N',
    value: ({ linear_up_to }) => linear_up_to,
  },
  {
    name: 'reach, most',
    title: 'Largest command that is carried out at some position',
    unit: 'N',
    value: ({ reachable_most }) => reachable_most,
  },
  {
    name: 'largest current',
    title: 'Of any phase',
    unit: 'A',
    value: ({ max_current }) => max_current,
  },
  {
    name: 'steepest current',
    title: 'Change of a current over position; times the velocity it is what amplifiers follow',
    unit: 'A/mm',
    value: ({ steepest_current }) => steepest_current / 1e3,
  },
];
