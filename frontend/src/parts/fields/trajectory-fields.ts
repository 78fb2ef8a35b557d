/** The numbers of a trajectory, whatever its kind, as lines of a form. */

import type { Choice, Value } from '../../app/api/types';
import { choicesOf } from '../../app/fields/fields.svelte';

/** What a person changes first; the rest is folded away. */
const MAIN = new Set([
  'radius',
  'circumradius',
  'amplitude',
  'frequency',
  'step',
  'count',
  'height',
  'velocity',
  'position',
  'duration',
  'start',
  'end',
  'edge_time',
  'v_max',
  'a_max',
]);

/** What `RepetitionChoice` shows. */
const REPETITION = new Set(['laps', 'cycles', 'for_ever']);

export type Line =
  | { kind: 'number'; path: string; main: boolean }
  | { kind: 'switch'; path: string; main: boolean; on: boolean }
  | { kind: 'choice'; path: string; main: boolean; value: string; options: readonly Choice[] }
  | { kind: 'list'; path: string; main: boolean; length: number };

/** Returns the lines for a trajectory's table, main ones first, but for those of its repetition. */
export function lines(trajectory: { [key: string]: Value }): Line[] {
  const rows: Line[] = [];
  for (const [key, value] of Object.entries(trajectory)) {
    if (REPETITION.has(key)) continue;
    const path = `trajectory.${key}`;
    const main = MAIN.has(key);
    if (typeof value === 'number' || value === null) {
      rows.push({ kind: 'number', path, main: main && value !== null });
    } else if (typeof value === 'boolean') {
      rows.push({ kind: 'switch', path, main, on: value });
    } else if (typeof value === 'string') {
      const options = choicesOf(path);
      if (options.length > 0) rows.push({ kind: 'choice', path, main, value, options });
    } else if (Array.isArray(value)) {
      rows.push({ kind: 'list', path, main: true, length: value.length });
    } else {
      for (const axis of Object.keys(value)) {
        rows.push({ kind: 'number', path: `${path}.${axis}`, main });
      }
    }
  }
  return rows.sort((a, b) => Number(b.main) - Number(a.main));
}
