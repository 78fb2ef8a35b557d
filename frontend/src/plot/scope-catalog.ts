/** The scopes there are: what each draws, with which colour and line. */

import type { Trace, Traces } from './scope-chart';
import { differenceName } from './source';
import type { Look } from './types';
import { looksOf } from './variant-looks';

type Axis = 'x' | 'y';
const AXES: readonly Axis[] = ['x', 'y'];

/** A column computed from two others: A less B. */
interface ColumnDifference {
  name: string;
  minuend: string;
  subtrahend: string;
}

export interface Scope extends Traces {
  id: ScopeId;
  title: string;
  difference?: ColumnDifference;
}

export const SCOPES = [
  { id: 'ex', short: 'e_x', title: 'Following error x' },
  { id: 'ey', short: 'e_y', title: 'Following error y' },
  { id: 'v', short: 'v', title: 'Velocity' },
  { id: 'a', short: 'a', title: 'Acceleration' },
  { id: 'i', short: 'i', title: 'Phase currents' },
  { id: 'f', short: 'F', title: 'Force and friction' },
] as const;

export type ScopeId = (typeof SCOPES)[number]['id'];

export const DEFAULT_SCOPES: readonly ScopeId[] = ['ex', 'ey', 'i', 'f'];

const PHASES: readonly ({ phase: string } & Look)[] = [
  { phase: 'a', ink: 'phase-a' },
  { phase: 'b', ink: 'phase-b', dash: 'dash' },
  { phase: 'c', ink: 'phase-c', dash: 'dot' },
];

/** Traces of one channel for A and B. */
function both(variants: readonly string[], rest: string): Trace[] {
  return variants.slice(0, 2).map((variant) => ({
    column: `${variant}.${rest}`,
    label: variant,
    ...looksOf(variant),
  }));
}

function motion(
  id: ScopeId,
  channel: string,
  unit: string,
  axis: Axis,
  variants: readonly string[],
) {
  const title = `${channel === 'velocity' ? 'Velocity' : 'Acceleration'} ${axis}`;
  const reference: Trace = {
    column: `${axis}.${channel}_reference`,
    label: 'reference',
    ink: 'reference',
    width: 2.5,
  };
  return { id, title, unit, traces: [reference, ...both(variants, `${axis}.${channel}`)] };
}

function followingError(axis: Axis, variants: readonly string[]): Scope {
  const id = axis === 'x' ? 'ex' : 'ey';
  const channel = `${axis}.following_error`;
  const traces = both(variants, channel);
  const [a, b] = variants;
  const scope: Scope = { id, title: `Following error ${axis}`, unit: 'm', traces, still: 1e-5 };
  if (a === undefined || b === undefined) return scope;
  const name = differenceName(channel, a, b);
  scope.difference = { name, minuend: `${a}.${channel}`, subtrahend: `${b}.${channel}` };
  traces.push({ column: name, label: `${a}−${b}`, ink: 'difference', dash: 'dash' });
  return scope;
}

/** Returns the scope of that id for the variants there are and the one that is looked at closely. */
export function scopeOf(
  id: ScopeId,
  variants: readonly string[],
  variant: string,
  axis: Axis,
): Scope {
  switch (id) {
    case 'ex':
      return followingError('x', variants);
    case 'ey':
      return followingError('y', variants);
    case 'v':
      return motion(id, 'velocity', 'm/s', axis, variants);
    case 'a':
      return motion(id, 'acceleration', 'm/s^2', axis, variants);
    case 'i':
      return {
        id,
        title: `Phase currents ${variant} ${axis}`,
        unit: 'A',
        traces: PHASES.map(({ phase, ...look }) => ({
          column: `${variant}.${axis}.current_${phase}`,
          label: phase,
          ...look,
        })),
      };
    case 'f':
      return {
        id,
        title: `Force and friction ${variant} ${axis}`,
        unit: 'N',
        traces: [
          { column: `${variant}.${axis}.thrust`, label: 'thrust', ink: 'reference' },
          { column: `${variant}.${axis}.friction`, label: 'friction', ink: 'phase-b', width: 2 },
          {
            column: `${variant}.${axis}.friction_estimate`,
            label: 'estimate',
            ink: 'phase-a',
            dash: 'dash',
          },
        ],
      };
  }
}

/** The differences there can be: computed whether shown or not, so that a scope has its past. */
export function differencesOf(variants: readonly string[]): ColumnDifference[] {
  return AXES.flatMap((axis) => followingError(axis, variants).difference ?? []);
}

/** Columns that the plane needs. */
function planeColumns(variants: readonly string[]): string[] {
  return [
    'x.position_reference',
    'y.position_reference',
    ...variants
      .slice(0, 2)
      .flatMap((variant) => [`${variant}.x.following_error`, `${variant}.y.following_error`]),
  ];
}

/** Columns to subscribe to: those of the plane and of these scopes, each once. */
export function columnsOf(
  scopes: readonly Pick<Scope, 'traces' | 'difference'>[],
  variants: readonly string[],
): string[] {
  const derived = new Set(scopes.map((scope) => scope.difference?.name));
  const drawn = scopes.flatMap((scope) => scope.traces.map((trace) => trace.column));
  return [
    ...new Set([...planeColumns(variants), ...drawn.filter((column) => !derived.has(column))]),
  ];
}
