/** Figures of views as rows of a table. */

import { digits, scaleFor } from '../../ui/units';

/** A row of figures; a dash where there is none. */
export interface Row {
  name: string;
  title: string;
  unit: string;
  cells: string[];
}

/** Below these a figure is nothing: a picometre, and what the others are to a 15 mm circle. */
const LEAST: Readonly<Record<string, number>> = { m: 1e-9, rad: 1e-8, '1': 1e-8, s: 1e-9 };
const SCALES: Readonly<Record<string, { factor: number; unit: string }>> = {
  rad: { factor: 1e6, unit: 'µrad' },
  '1': { factor: 1e6, unit: 'ppm' },
  s: { factor: 1e6, unit: 'µs' },
};

/** Writes values of one SI unit with one prefix. */
export function row(name: string, title: string, unit: string, values: (number | null)[]): Row {
  const known = values.filter((value) => value !== null).map(Math.abs);
  const scale = SCALES[unit] ?? scaleFor(Math.max(1e-9, ...known), unit);
  const text = (value: number | null) => {
    if (value === null) return '–';
    return Math.abs(value) < (LEAST[unit] ?? 0) ? '0' : digits(value * scale.factor);
  };
  return { name, title, unit: scale.unit, cells: values.map(text) };
}
