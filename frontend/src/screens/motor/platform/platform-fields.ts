/** What the platforms are asked with. Paths of `both` belong to the previous and the new design. */

import type { Changes, PlatformDocument, Value } from '../../../app/api/types';
import { nested } from '../../../study/study-form.svelte';
import { numberIn, type Group } from '../quantity-fields';

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

/** The path in a request: one force stands for four, what belongs to both is named as of the new one. */
export function inRequest(path: string): string {
  return path === FORCE ? 'load.forces' : path.replace(/^both\./, 'new.');
}

/** The request's body. */
export function bodyOf(entered: Changes, axis: string, support: string): Record<string, unknown> {
  const values: Record<string, Value> = { axis };
  for (const [path, value] of Object.entries(entered)) {
    const name = path.split('.')[1] as string;
    if (path === FORCE) values['load.forces'] = Array.from({ length: 4 }, () => value);
    else if (path.startsWith('both.')) for (const one of DESIGNS) values[`${one}.${name}`] = value;
    else if (path !== 'map.name' || value !== '') values[path] = value;
  }
  for (const one of DESIGNS) values[`${one}.support`] = support;
  return nested(values);
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
export function valueIn(answer: PlatformDocument | null, path: string): number | null {
  const [of, name] = path.split('.') as [string, string];
  if (answer === null) return null;
  if (path === FORCE) return answer.load.forces[0];
  if (of === 'load') return numberIn(answer.load, name);
  const shape = answer.designs[of === 'previous' ? 'previous' : 'new']?.shape;
  return numberIn(shape, name);
}
