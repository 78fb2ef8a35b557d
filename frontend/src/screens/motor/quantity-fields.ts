/** Numbers of the Motor screen: in tables, and as computed. */

import { digits, minus, quantity, scaleFor, type Quantity } from '../../ui/units';

/** Fields of a form below a heading, by their paths. */
export interface Group {
  title: string;
  paths: readonly string[];
}

/** Dotted path to number, as far as a person has changed them. */
export type Numbers = Readonly<Record<string, number>>;

/** The number at a dotted path, or null. */
export function numberIn(document: unknown, path: string): number | null {
  let value: unknown = document;
  for (const key of path.split('.')) {
    value =
      typeof value === 'object' && value !== null ? (value as Record<string, unknown>)[key] : null;
  }
  return typeof value === 'number' ? value : null;
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
