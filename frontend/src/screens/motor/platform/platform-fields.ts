/** What the platforms are asked with. Paths of `both` belong to the previous and the new design. */

import type { Axis, PlatformDocument } from '../../../app/api/types';
import {
  fieldAt,
  nested,
  numberIn,
  type Field,
  type Group,
  type Numbers,
} from '../quantity-fields';

export type DesignName = 'previous' | 'new';
export const DESIGNS: readonly DesignName[] = ['previous', 'new'];

/** The field of one force, which all four movers pull with. */
export const FORCE = 'load.force';

const below = (of: string, names: readonly string[]) => names.map((name) => `${of}.${name}`);
const PLATE = ['thickness', 'ribs_x', 'ribs_y', 'rib_width', 'rib_height'];

export const GROUPS: readonly Group[] = [
  { title: 'Previous design', paths: below('previous', PLATE) },
  { title: 'New design', paths: below('new', PLATE) },
  { title: 'Both', paths: below('both', ['length', 'width', 'span_x', 'span_y', 'E']) },
  { title: 'Movers', paths: below('load', ['spacing_x', 'spacing_y']) },
];

const PATHS = [FORCE, ...GROUPS.flatMap(({ paths }) => paths)];

export function platformField(path: string): Field {
  const inRequest = path === FORCE ? 'load.forces' : path.replace(/^both\./, 'new.');
  return fieldAt('platform', path, inRequest);
}

export const platformFields = (): Field[] => PATHS.map(platformField);

export interface Asked {
  axis: Axis;
  set: Numbers;
  support: string;
  /** Name of the force map that pulls; empty where forces are given. */
  map: string;
}

/** The request's body. */
export function bodyOf({ axis, set, support, map }: Asked): Record<string, unknown> {
  const numbers: Record<string, number> = {};
  let force: number | null = null;
  for (const [path, value] of Object.entries(set)) {
    const [of, name] = path.split('.') as [string, string];
    if (path === FORCE) force = value;
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
  if (path === FORCE) return found.load.forces[0];
  if (of === 'load') return numberIn(found.load, name);
  const shape = found.designs[of === 'previous' ? 'previous' : 'new']?.shape;
  return numberIn(shape, name);
}
