/** The rows of the table of parameters, and the warnings below it. */

import type { AxisIdentification } from '../../app/api/types';
import { digits, inScale, PER_MM, percent, scaleFor, type Scale } from '../../ui/units';

type Parameters = AxisIdentification['sliding']['parameters'];
export type Parameter = Parameters[string];

const MEANINGS: Record<string, string> = {
  F_c: 'Coulomb friction',
  F_s: 'stiction',
  v_s: 'Stribeck velocity',
  sigma_2: 'viscous friction',
  f_0: 'what pulls one way at any velocity: a cable, an incline',
  sigma_0: 'bristle stiffness',
  sigma_1: 'bristle damping',
  M: 'moving mass, in newtons of the controller’s map; other than the known mass where the force map is off',
};

export interface ParameterRow {
  name: string;
  meaning: string;
  unit: string;
  believed: string;
  value: string;
  /** Half of the 95 % interval, or that there is none. */
  half: string;
  interval: string;
  true: string;
  error: string;
  /** Of the earlier record beside it. */
  other: string;
  change: string;
}

const LETTERS: Record<string, string> = { sigma_0: 'σ_0', sigma_1: 'σ_1', sigma_2: 'σ_2' };

/** Units that the Lab's controls have. */
const FIXED: Readonly<Record<string, Scale>> = {
  sigma_0: PER_MM.stiffness,
  sigma_1: PER_MM.damping,
  sigma_2: { factor: 1, unit: 'N s/m' },
};

/** Returns all parameters of an axis by name. */
export function parametersOf(identified: AxisIdentification): Parameters {
  return { ...identified.sliding.parameters, ...(identified.presliding?.parameters ?? {}) };
}

export function rowsOf(
  identified: AxisIdentification,
  other: AxisIdentification | null,
): ParameterRow[] {
  const beside = other ? parametersOf(other) : {};
  return Object.entries(parametersOf(identified)).map(([name, parameter]) =>
    row(name, parameter, beside[name]),
  );
}

function row(name: string, parameter: Parameter, other: Parameter | undefined): ParameterRow {
  const { value, unit, low, high, believed } = parameter;
  const real = parameter.true;
  const half = high === null ? null : high - value;
  const size = Math.max(Math.abs(believed ?? 0), Math.abs(value), Math.abs(real ?? 0), half ?? 0);
  const scale = FIXED[name] ?? scaleFor(size, unit);
  const lost = half !== null && half > Math.abs(value);
  const text = (n: number | null | undefined) =>
    n === null || n === undefined ? '–' : digits(n * scale.factor, 4);
  return {
    name: LETTERS[name] ?? name,
    meaning: MEANINGS[name] ?? '',
    unit: scale.unit,
    believed: text(believed),
    // What is below its own uncertainty needs no digits of its own.
    value: lost ? inScale(value, scale) : text(value),
    half: half === null ? 'unknown' : small(half * scale.factor),
    interval:
      low === null || high === null
        ? 'The data do not determine it.'
        : `95 % interval: ${text(low)} to ${text(high)} ${scale.unit}`,
    true: text(real),
    error: share(value, real),
    other: text(other?.value),
    // Two numbers that are lost in their scatter do not compare.
    change: lost ? '–' : share(value, other?.value),
  };
}

/** Two digits, but no more than three decimals. */
function small(value: number): string {
  return value < 0.0005 ? '<0.001' : digits(Number(value.toFixed(3)), 2);
}

function share(value: number, reference: number | null | undefined): string {
  if (reference === null || reference === undefined || reference === 0) return '–';
  return percent(value / reference - 1);
}

/** All warnings of an axis, each once. */
export function warningsOf(identified: AxisIdentification): string[] {
  const all = [
    ...identified.warnings,
    ...identified.sliding.warnings,
    ...(identified.presliding?.warnings ?? []),
  ].map(sentence);
  return [...new Set(all)];
}

/** Begins with a capital, unless the first word is a symbol such as v_s. */
function sentence(text: string): string {
  return /^[a-z]+ /.test(text) ? text.charAt(0).toUpperCase() + text.slice(1) : text;
}
