/** Rows of the loop's figures: margins of both loops, and what eqs (39) to (42) promise of one. */

import { at } from '../../app/api/scenario-paths';
import type { Axis, Scenario } from '../../app/api/types';
import { digits, scaleFor } from '../../ui/units';
import type { LoopAt, LoopFigures } from '../../parts/loop/loops.svelte';
import { inDecibels, inDegrees } from '../../parts/loop/margins';
import type { LookedAt } from './loop-store.svelte';

export interface FigureRow {
  name: string;
  unit: string;
  title: string;
  values: string[];
}

const MARGINS: readonly {
  name: string;
  unit: string;
  title: string;
  read: (figures: LoopAt) => string;
}[] = [
  {
    name: 'stable',
    unit: '',
    title: 'Whether every pole of the linearised sampled loop lies inside the unit circle',
    read: ({ stable }) => (stable ? 'yes' : 'no'),
  },
  {
    name: 'gain margin',
    unit: 'dB',
    title: 'By which the loop’s gain may grow to the stability boundary',
    read: ({ gain_margin }) => inDecibels(gain_margin),
  },
  {
    name: 'phase margin',
    unit: '°',
    title: 'Smallest distance of L from −180° where its gain is one',
    read: ({ phase_margin }) => inDegrees(phase_margin),
  },
  {
    name: 'M_s',
    unit: '',
    title: 'Peak of the sensitivity 1/(1 + L)',
    read: ({ Ms }) => digits(Ms),
  },
  {
    name: 'bandwidth',
    unit: 'Hz',
    title: '−3 dB of L/(1 + L)',
    read: ({ bandwidth }) => number(bandwidth),
  },
];

/** Those of the rows that are shown at standstill too. */
const AT_REST: ReadonlySet<string> = new Set(['stable', 'gain margin', 'phase margin']);

function number(value: number | null, factor = 1): string {
  return value === null ? '–' : digits(value * factor);
}

/** Margins of the present loop and of the chosen one, with the velocity at which they hold. */
export function marginRows(present: LookedAt | null, chosen: LookedAt | null): FigureRow[] {
  const figures = (chosen ?? present)?.figures;
  const speed = figures ? ` at ${digits(figures.velocity * 1e3)} mm/s` : '';
  const sliding = MARGINS.map(({ name, unit, title, read }) => ({
    name: name.endsWith('margin') || name === 'M_s' ? `${name}${speed}` : name,
    unit,
    title,
    values: [present, chosen].map((looked) => (looked?.figures ? read(looked.figures) : '–')),
  }));
  const atRest = MARGINS.filter(({ name }) => AT_REST.has(name)).map(
    ({ name, unit, title, read }) => ({
      name: `${name} at standstill`,
      unit,
      title: `${title}, while the axis is stuck and its bristle is a spring`,
      values: [present, chosen].map((looked) =>
        looked?.figures ? read(looked.figures.standstill) : '–',
      ),
    }),
  );
  return [...sliding, ...atRest];
}

/** Says at which velocity the margins hold. */
export function marginNote({ figures }: LookedAt): string {
  if (!figures) return '';
  return `Sliding at ${digits(figures.velocity * 1e3)} mm/s, four Stribeck velocities; margins of candidates and in the Lab are the worst from 0.5 to 4 and at standstill.`;
}

/** Errors of one loop by the equations, and simulated without and with friction. */
export function promiseRows({ accuracy, figures }: LookedAt): FigureRow[] {
  const { sine } = accuracy;
  const rows: FigureRow[] = [
    {
      name: 'crossover (39)',
      unit: 'Hz',
      title: 'Eq. (39) against the linearised loop',
      values: [number(accuracy.crossover), '–', number(figures?.crossover ?? null)],
    },
    lengths(
      'error at largest a (40)',
      `Eq. (40) at ${digits(accuracy.acceleration)} m/s², the motion’s largest; beside it the largest error`,
      [accuracy.parabola, accuracy.ideal_peak, accuracy.simulated_peak],
    ),
  ];
  if (!sine) return rows;
  const at = `of a sine of ${digits(sine.amplitude * 1e3)} mm at ${digits(sine.frequency)} Hz, the motion’s fundamental`;
  return [
    ...rows,
    lengths('error of the sine (41)', `Amplitude of the error ${at}`, [
      sine.predicted,
      sine.ideal,
      sine.simulated,
    ]),
    {
      name: 'its phase (42)',
      unit: '°',
      title: `Phase of the error ${at}; (42) as printed lacks the quadrant`,
      values: [sine.predicted_phase, sine.ideal_phase, sine.simulated_phase].map(inDegrees),
    },
  ];
}

/** Explains why the columns differ: effects outside the equations, and equations that do not apply.
 */ export function promiseNote({ accuracy }: LookedAt, scenario: Scenario | null): string {
  const coupling = at(scenario, `plant.${accuracy.axis}.resonance.coupling`) ?? 0;
  const unknown = [
    ...(coupling !== 0 ? ['the resonance of this motor'] : []),
    'friction',
    'sampling',
    'delay',
  ];
  const last = unknown.pop() ?? '';
  const note = `The equations are of a mass under PD control in continuous time: they do not know ${unknown.join(', ')} or ${last}.`;
  const none = ' This motion does not repeat: (41) and (42), which are of a sine, do not apply.';
  const away = ' A dash stands where the simulation diverged.';
  const ran = accuracy.simulated_peak === null || accuracy.ideal_peak === null;
  return `${note}${accuracy.sine ? '' : none}${ran ? away : ''}`;
}

/** One prefix for the row, so that its numbers compare at a glance. */
function lengths(name: string, title: string, values: (number | null)[]): FigureRow {
  const known = values.filter((value) => value !== null);
  const { factor, unit } = scaleFor(Math.max(...known), 'm');
  return { name, unit, title, values: values.map((value) => number(value, factor)) };
}

/** Returns what is wrong with chosen gains, and at which gain the loop would be stable. */
export function limitWarnings(figures: LoopFigures | null, axis: Axis): string[] {
  if (!figures) return [];
  return [figures, figures.standstill].flatMap((loop) => warning(loop, axis));
}

function warning(figures: LoopAt, axis: Axis): string[] {
  if (figures.stable) return [];
  const edges = [
    ['k_p', figures.k_p_limit, 'N/mm'] as const,
    ['k_d', figures.k_d_limit, 'N s/mm'] as const,
  ].flatMap(([gain, limit, unit]) =>
    limit === null ? [] : [`${gain} = ${digits(limit / 1e3, 4)} ${unit}`],
  );
  const nearest =
    edges.length > 0 ? ` The stability boundary, each gain moved alone: ${edges.join(', ')}.` : '';
  const where = figures.velocity === 0 ? ' at standstill' : '';
  return [`The chosen gains of ${axis} are unstable${where}.${nearest}`];
}
