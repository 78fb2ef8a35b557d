/** Numbers that one types on the Motor screen: what the server calls them, and their refusals. */

import type { ProblemField, StudyKind } from '../../app/api/types';
import {
  entryOf,
  fieldOf,
  refusalText,
  served,
  type Field as Shown,
} from '../../app/fields/fields.svelte';
import { digits, minus, prettyUnit, quantity, scaleFor, type Quantity } from '../../ui/units';

export interface Field extends Shown {
  /** Dotted path in the form. */
  path: string;
  /** The field's symbol, as `l_m`. */
  symbol: string;
  description: string;
}

/** Fields of a form below a heading, by their paths. */
export interface Group {
  title: string;
  paths: readonly string[];
}

/** Returns a field of a form, whose path in the request may be another. */
export function fieldAt(kind: StudyKind, path: string, inRequest = path): Field {
  const entries = served.requests[kind] ?? {};
  const { symbol, description } = entryOf(inRequest, entries) ?? {};
  const shown = fieldOf(inRequest, entries);
  return { ...shown, path, symbol: symbol ?? '', description: description ?? '' };
}

/** Dotted path to number, as far as a person has changed them. */
export type Numbers = Readonly<Record<string, number>>;

/** Puts dotted paths into tables: `{'x.mass': 5}` becomes `{x: {mass: 5}}`. */
export function nested(numbers: Numbers): Record<string, unknown> {
  const root: Record<string, unknown> = {};
  for (const [path, value] of Object.entries(numbers)) {
    const keys = path.split('.');
    let table = root;
    for (const key of keys.slice(0, -1)) {
      table = (table[key] ??= {}) as Record<string, unknown>;
    }
    table[keys[keys.length - 1] as string] = value;
  }
  return root;
}

/** The number at a dotted path, or null. */
export function numberIn(document: unknown, path: string): number | null {
  let value: unknown = document;
  for (const key of path.split('.')) {
    value =
      typeof value === 'object' && value !== null ? (value as Record<string, unknown>)[key] : null;
  }
  return typeof value === 'number' ? value : null;
}

/**
 * Says what is refused beside the fields of a form. What the server has against a table as a whole
 * belongs to the number that was changed last.
 */
export function refusals(
  errors: readonly ProblemField[],
  fields: readonly Field[],
  last: string | null,
): Record<string, string> {
  const found: Record<string, string> = {};
  for (const error of errors) {
    const own = fields.find(({ path }) => path === error.loc);
    const place = own?.path ?? (last !== null && last.startsWith(error.loc) ? last : '');
    const unit = own?.unit ?? prettyUnit(error.unit ?? '');
    const text = refusalText(error, { factor: own?.factor ?? 1, unit });
    found[place] = place in found ? `${found[place] ?? ''} ${text}` : text;
  }
  return found;
}

const GREEK: readonly [RegExp, string][] = [
  [/\bDelta /g, 'Δ'],
  [/\bdelta_/g, 'δ_'],
  [/\btau\b/g, 'τ'],
  [/\bsigma\b/g, 'σ'],
  [/\blambda\b/g, 'λ'],
  [/\bpsi\b/g, 'ψ'],
  [/\bmu_/g, 'μ_'],
  [/\bsqrt\(/g, '√('],
  [/ - /g, ' − '],
  [/\^2/g, '²'],
];

/** Writes the letters of a formula: tau as τ. Subscripts are left to ui/Symbol. */
export function formula(text: string): string {
  return GREEK.reduce((done, [word, letter]) => done.replace(word, letter), text);
}

/** Formats a computed value with four digits; areas in mm², whole numbers as such. */
export function computed(value: number | null, unit: string): Quantity {
  if (value === null || !Number.isFinite(value)) return quantity(null, unit);
  if (unit === 'm^2') return { number: four(value * 1e6), unit: 'mm²' };
  // Velocities are compared with printed ones, which are in m/s.
  const plain = unit === 'm/s' && Math.abs(value) >= 0.1;
  const scale = plain ? { factor: 1, unit } : scaleFor(value, unit);
  return { number: four(value * scale.factor), unit: scale.unit };
}

function four(value: number): string {
  if (Number.isInteger(value)) return minus(String(value));
  const text = digits(value, 4);
  return text.includes('.') && !text.includes('e') ? text.replace(/\.?0+$/, '') : text;
}
