/** How often a motion is done: once, a number of times, or for ever in a live session. */

import type { Value } from '../../app/api/types';

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
