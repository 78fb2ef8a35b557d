/** What the platforms are asked with. Paths of `both` belong to the previous and the new design. */

import type { Axis, PlatformDocument } from '../../../app/api/types';
import { nested, numberIn, type Field, type Numbers } from '../quantity-fields';

export type DesignName = 'previous' | 'new';
export const DESIGNS: readonly DesignName[] = ['previous', 'new'];

export const SUPPORTS = ['carriages', 'guides', 'edges', 'clamped'] as const;
export type Support = (typeof SUPPORTS)[number];

export interface Group {
  title: string;
  fields: readonly Field[];
}

const MM = { factor: 1e3, unit: 'mm' };

const design = (of: DesignName): Field[] => [
  { path: `${of}.thickness`, label: 'Thickness', symbol: 't', ...MM },
  { path: `${of}.ribs_x`, label: 'Ribs along x', whole: true },
  { path: `${of}.ribs_y`, label: 'Ribs along y', whole: true },
  { path: `${of}.rib_width`, label: 'Rib width', symbol: 'w', ...MM },
  { path: `${of}.rib_height`, label: 'Rib height', symbol: 'h', ...MM },
];

export const FORCE: Field = { path: 'load.force', label: 'Each normal force', unit: 'N' };

export const GROUPS: readonly Group[] = [
  { title: 'Previous design', fields: design('previous') },
  { title: 'New design', fields: design('new') },
  {
    title: 'Both',
    fields: [
      { path: 'both.length', label: 'Length along x', ...MM },
      { path: 'both.width', label: 'Width along y', ...MM },
      { path: 'both.span_x', label: 'Supports apart, x', ...MM },
      { path: 'both.span_y', label: 'Supports apart, y', ...MM },
      { path: 'both.E', label: "Young's modulus", symbol: 'E', factor: 1e-9, unit: 'GPa' },
    ],
  },
  {
    title: 'Movers',
    fields: [
      { path: 'load.spacing_x', label: 'Apart along x', ...MM },
      { path: 'load.spacing_y', label: 'Apart along y', ...MM },
    ],
  },
];

export const FIELDS: readonly Field[] = [FORCE, ...GROUPS.flatMap(({ fields }) => fields)];

export interface Asked {
  axis: Axis;
  set: Numbers;
  support: Support;
  /** Name of the force map that pulls; empty where forces are given. */
  map: string;
}

/** The request's body. */
export function bodyOf({ axis, set, support, map }: Asked): Record<string, unknown> {
  const numbers: Record<string, number> = {};
  let force: number | null = null;
  for (const [path, value] of Object.entries(set)) {
    const [of, name] = path.split('.') as [string, string];
    if (path === FORCE.path) force = value;
    else if (of === 'both') for (const one of DESIGNS) numbers[`${one}.${name}`] = value;
    else numbers[path] = value;
  }
  const tables = nested(numbers) as Record<string, Record<string, unknown>>;
  for (const one of DESIGNS) tables[one] = { ...tables[one], support };
  if (force !== null) tables['load'] = { ...tables['load'], forces: [force, force, force, force] };
  return { axis, ...tables, ...(map === '' ? {} : { map: { name: map } }) };
}

/** Ends of one colour axis for all pictures, zero among them: what bends less looks so. */
export function shared(pictures: readonly (readonly (readonly number[])[])[]): {
  from: number;
  to: number;
} {
  const ends = pictures.flatMap((rows) =>
    rows.flatMap((row) => [Math.min(...row), Math.max(...row)]),
  );
  return { from: Math.min(0, ...ends), to: Math.max(0, ...ends) };
}

/** What the server took for a field. */
export function valueIn(found: PlatformDocument | null, path: string): number | null {
  const [of, name] = path.split('.') as [string, string];
  if (found === null) return null;
  if (path === FORCE.path) return found.load.forces[0];
  if (of === 'load') return numberIn(found.load, name);
  const shape = found.designs[of === 'previous' ? 'previous' : 'new']?.shape;
  return numberIn(shape, name);
}
