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

export type Repetition = 'once' | 'times' | 'ever';

export interface Repeats {
  mode: Repetition;
  /** Name of the field that counts laps. */
  count: 'laps' | 'cycles';
  laps: number;
  /** Why it can run once only; empty where it can be repeated. */
  only: string;
}

type Table = Readonly<{ [key: string]: Value }>;

const ELSEWHERE = 'It ends elsewhere than it begins';

/** Returns how often a motion is done; null of a kind that has no laps. */
export function repeats(table: Table): Repeats | null {
  const count = 'cycles' in table ? 'cycles' : 'laps';
  const laps = table[count];
  if (typeof laps !== 'number') return null;
  const only = endsElsewhere(table) ? ELSEWHERE : '';
  const ever = only === '' && table.for_ever !== false;
  return { mode: ever ? 'ever' : laps > 1 ? 'times' : 'once', count, laps, only };
}

/** Returns the fields that make a motion repeat otherwise. */
export function repeated(
  { count, laps }: Repeats,
  mode: Repetition,
): { [key: string]: number | boolean } {
  if (mode === 'ever') return { for_ever: true };
  return { for_ever: false, [count]: mode === 'once' ? 1 : Math.max(2, laps) };
}

/** Says what the choice means for a session, and for all that has an end. */
export function meaning({ mode, laps, only }: Repeats): string {
  const times = laps === 1 ? 'one lap' : `${laps} laps`;
  if (only !== '') return `${only}: a session runs it once.`;
  if (mode === 'ever')
    return `A session repeats it for ever; runs and what-ifs end after ${times}.`;
  return `A session ends after ${times}, like runs and what-ifs; Play starts it again.`;
}

function endsElsewhere(table: Table): boolean {
  if (table.kind === 'path') return table.closed !== true;
  if ('there_and_back' in table) return table.there_and_back !== true;
  if (table.kind !== 'waypoints' || !Array.isArray(table.points)) return false;
  return JSON.stringify(table.points.at(0)) !== JSON.stringify(table.points.at(-1));
}
