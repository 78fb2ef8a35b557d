/** How each number of a scenario is called and in which unit a person meets it. */

import { clean, digits, minus, pretty, prettyUnit } from '../../ui/units';
import type { ProblemField, Value } from '../api/types';
import { LAWS, SHARINGS } from './laws';

export interface Field {
  label: string;
  /** Unit on the screen. */
  unit: string;
  /** Displayed number = SI value times this. */
  factor: number;
  whole?: boolean;
}

type Entry = readonly [label: string, unit: string, factor: number];

const MM: readonly [string, number] = ['mm', 1e3];
const UM: readonly [string, number] = ['µm', 1e6];
const NM: readonly [string, number] = ['nm', 1e9];
const DEGREE: readonly [string, number] = ['°', 180 / Math.PI];

/** By the end of a path; the longest end that fits wins. */
const FIELDS: Record<string, Entry> = {
  'x.k_p': ['k_p x', 'N/mm', 1e-3],
  'x.k_d': ['k_d x', 'N s/mm', 1e-3],
  'y.k_p': ['k_p y', 'N/mm', 1e-3],
  'y.k_d': ['k_d y', 'N s/mm', 1e-3],
  'x.notch.frequency': ['notch frequency x', 'Hz', 1],
  'x.notch.damping': ['notch damping x', '', 1],
  'x.notch.gain': ['notch gain x', '', 1],
  'y.notch.frequency': ['notch frequency y', 'Hz', 1],
  'y.notch.damping': ['notch damping y', '', 1],
  'y.notch.gain': ['notch gain y', '', 1],
  'sharing.law': ['force sharing', '', 1],
  'sharing.overlap': ['overlap', '% of pitch', 100],
  'compensation.law': ['law', '', 1],
  'compensation.enabled': ['compensation', '', 1],
  'compensation.gain': ['gain of K', '1/s', 1],
  feedforward: ['feedforward', '', 1],
  'disturbance_observer.enabled': ['disturbance observer', '', 1],
  'disturbance_observer.bandwidth': ['observer bandwidth', 'Hz', 1],
  seed: ['seed', '', 1],
  plant: ['motor', '', 1],
  trajectory: ['trajectory', '', 1],
  'trajectory.radius': ['radius', ...MM],
  'trajectory.circumradius': ['circumradius', ...MM],
  'trajectory.frequency': ['frequency', 'Hz', 1],
  'trajectory.laps': ['laps', '', 1],
  'trajectory.cycles': ['cycles', '', 1],
  'trajectory.count': ['steps', '', 1],
  'trajectory.points': ['points', '', 1],
  'trajectory.density': ['density', '', 1],
  'trajectory.direction': ['direction', '', 1],
  'trajectory.there_and_back': ['there and back', '', 1],
  'trajectory.start_angle': ['start angle', ...DEGREE],
  'trajectory.dwell': ['dwell', 's', 1],
  'trajectory.delay': ['delay', 's', 1],
  'trajectory.duration': ['duration', 's', 1],
  'trajectory.lead_in': ['lead-in', 's', 1],
  'trajectory.edge_time': ['time of an edge', 's', 1],
  'trajectory.v_max': ['max speed', 'mm/s', 1e3],
  'trajectory.a_max': ['max accel.', 'm/s²', 1],
  'center.x': ['centre x', ...MM],
  'center.y': ['centre y', ...MM],
  'start.x': ['start x', ...MM],
  'start.y': ['start y', ...MM],
  'end.x': ['end x', ...MM],
  'end.y': ['end y', ...MM],
  'position.x': ['position x', ...MM],
  'position.y': ['position y', ...MM],
  'amplitude.x': ['amplitude x', ...MM],
  'amplitude.y': ['amplitude y', ...MM],
  'step.x': ['step x', ...UM],
  'step.y': ['step y', ...UM],
  'height.x': ['height x', ...UM],
  'height.y': ['height y', ...UM],
  'velocity.x': ['velocity x', 'mm/s', 1e3],
  'velocity.y': ['velocity y', 'mm/s', 1e3],
  'phase.x': ['phase x', ...DEGREE],
  'phase.y': ['phase y', ...DEGREE],
  mass: ['mass', 'kg', 1],
  'friction.F_s': ['stiction F_s', 'N', 1],
  'friction.F_c': ['Coulomb F_c', 'N', 1],
  'friction.v_s': ['speed v_s', 'mm/s', 1e3],
  'friction.sigma_0': ['stiffness σ_0', 'N/mm', 1e-3],
  'friction.sigma_1': ['damping σ_1', 'N s/mm', 1e-3],
  'friction.sigma_2': ['viscous σ_2', 'N s/m', 1],
  force_map: ['force map', '', 1],
  'force_map.gain': ['map gain', '', 1],
  'force_map.F_pk': ['peak thrust', 'N', 1],
  'force_map.I_knee': ['saturation I_knee', 'A', 1],
  'force_map.h_2': ['harmonic h_2', '', 1],
  'force_map.h_3': ['harmonic h_3', '', 1],
  'force_map.offset': ['commutation', ...UM],
  'amplifiers.bandwidth': ['bandwidth', 'Hz', 1],
  'amplifiers.ripple_amplitude': ['ripple', 'A', 1],
  'amplifiers.noise': ['noise', 'A', 1],
  'encoder.resolution': ['encoder count', ...NM],
  'encoder.sde_amplitude': ['encoder error', ...NM],
  'encoder.noise': ['encoder noise', ...NM],
  'resonance.frequency': ['resonance', 'Hz', 1],
  'resonance.damping': ['mode damping', '', 1],
  'resonance.coupling': ['mode coupling', '', 1],
  'load.x': ['load x', 'N', 1],
  'load.y': ['load y', 'N', 1],
  'load.noise': ['load noise', 'N', 1],
};

const WHOLE = new Set(['seed', 'laps', 'cycles', 'count', 'points', 'density']);

/** Returns how a path's value is shown. */
export function fieldOf(path: string): Field {
  const steps = path.split('.');
  for (let i = 0; i < steps.length; i++) {
    const entry = FIELDS[steps.slice(i).join('.')];
    if (!entry) continue;
    const [label, unit, factor] = entry;
    const field: Field = { label, unit: prettyUnit(unit), factor };
    return WHOLE.has(steps.at(-1) ?? '') ? { ...field, whole: true } : field;
  }
  return { label: steps.slice(-2).join(' ').replaceAll('_', ' '), unit: '', factor: 1 };
}

/** Returns who a path belongs to: `B`, `plant x`, or nothing. */
export function ownerOf(path: string): string {
  const [, variant] = /^variants\.([A-Z])\./.exec(path) ?? [];
  if (variant !== undefined) return variant;
  const [, axis] = /^plant\.([xy])\./.exec(path) ?? [];
  return axis === undefined ? '' : `plant ${axis}`;
}

/** Returns what a change is called: `B k_p x`, `B stiction F_s y`. */
export function nameOf(path: string): string {
  const [, axis] = /\.model\.([xy])\./.exec(path) ?? [];
  return `${ownerOf(path)} ${fieldOf(path).label} ${axis ?? ''}`.trim();
}

/** Writes a value for reading; `significant` digits. */
export function show(path: string, value: Value | undefined, significant = 4): string {
  if (value === undefined || value === null) return 'auto';
  if (typeof value === 'boolean') return value ? 'on' : 'off';
  if (typeof value === 'string')
    return [...LAWS, ...SHARINGS].find(({ law }) => law === value)?.name ?? value;
  if (typeof value === 'number') {
    const { factor, whole } = fieldOf(path);
    return whole === true ? String(value) : trim(digits(clean(value * factor), significant));
  }
  if (Array.isArray(value)) return value.map((item) => show(path, item)).join(', ');
  return 'changed';
}

/** Writes what is wrong with a field, its range in the unit of the screen. */
export function refusal({ loc, message: plain, value, range, unit }: ProblemField): string {
  const message = pretty(plain);
  const words = message.charAt(0).toUpperCase() + message.slice(1).replace(/\.$/, '');
  const text = `${words}${typeof value === 'number' ? `: ${amount(loc, value, unit)}` : ''}.`;
  if (range === undefined || range === '') return text;
  const { factor, unit: shown } = fieldOf(loc);
  const scaled = range
    .replace(/-?\d+(\.\d+)?(e[+-]?\d+)?/gi, (number) =>
      trim(digits(clean(Number(number) * factor), 6)),
    )
    .replace(/^>= (\S+) and <= (\S+)$/, '$1 to $2')
    .replaceAll('>=', '≥')
    .replaceAll('<=', '≤');
  return (
    `${text} Allowed: ${scaled} ${shown === '' ? prettyUnit(unit ?? '') : shown}`.trimEnd() + '.'
  );
}

function amount(loc: string, value: number, unit: string | undefined): string {
  const { factor, unit: shown } = fieldOf(loc);
  return `${trim(digits(value * factor))} ${shown === '' ? prettyUnit(unit ?? '') : shown}`.trimEnd();
}

/** Writes a value into a field: no more digits than it has, and an ASCII minus. */
export function editable(path: string, value: number): string {
  const { factor, whole } = fieldOf(path);
  if (!Number.isFinite(value)) return '';
  return whole === true ? String(value) : String(Number(clean(value * factor).toPrecision(4)));
}

function trim(text: string): string {
  return minus(text.includes('.') && !text.includes('e') ? text.replace(/\.?0+$/, '') : text);
}
