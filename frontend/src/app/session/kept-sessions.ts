/** What this browser keeps of the sessions it had open, so that each is found again as it was left. */

import { equal } from '../api/scenario-paths';
import type { Changes, Scenario, Trajectory } from '../api/types';
import { discard, type Form, listOf, load, recordOf, save } from '../storage';

/** Paths of a session whose names are known. */
const PATHS = 4;

/** Number of sessions kept; the oldest is dropped for another one. */
const MOST = 8;

/** A path that was taken from the Trajectories screen, by its saved name; a drawn one has none. */
export interface GivenPath {
  name: string;
  table: Trajectory;
}

export const GIVEN_PATH: Form = { name: '', table: { kind: '' } };

const SCENARIO: Form = {
  name: '',
  plant: { x: {}, y: {} },
  variants: recordOf({ controller: {} }),
  trajectory: { kind: '' },
};

const SESSION: Form = {
  base: SCENARIO,
  scenario: SCENARIO,
  paths: listOf(GIVEN_PATH),
  speed: 0,
};

/** What belongs to a session and is not on the server. */
export interface Own {
  /** What differences are shown against: the scenario as it was loaded. */
  base: Scenario;
  /** What-if changes that the session does not have. */
  draft: Changes;
  /** Paths that were given to it or tried in what-if, the last one first. */
  paths: readonly GivenPath[];
  /** Simulated over real time. */
  speed: number;
}

export interface Kept extends Own {
  id: string;
  scenario: Scenario;
}

/** Returns the ids of the sessions that are kept, the last one first. */
export function keptSessions(): readonly string[] {
  return load<readonly string[]>('sessions', [], listOf(''));
}

/** Returns what is kept of a session, or null. */
export function recall(id: string): Kept | null {
  const kept = load<Omit<Kept, 'id' | 'draft'> | null>(`session.${id}`, null, SESSION);
  return kept && { id, ...kept, draft: keptDraft(id) };
}

export function remember({ id, scenario, base, paths, speed }: Omit<Kept, 'draft'>): void {
  const others = keptSessions().filter((other) => other !== id);
  save('sessions', [id, ...others.slice(0, MOST - 1)]);
  others.slice(MOST - 1).forEach(forget);
  save(`session.${id}`, { scenario, base, paths, speed });
}

/** What-if changes alone: they are kept while a slider moves. */
export function rememberDraft(id: string, draft: Changes): void {
  save(`draft.${id}`, draft);
}

/** Forgets a session that ended or lives on under another id. */
export function forget(id: string): void {
  save(
    'sessions',
    keptSessions().filter((other) => other !== id),
  );
  discard(`session.${id}`);
  discard(`draft.${id}`);
}

export function keptDraft(id: string): Changes {
  return load<Changes>(`draft.${id}`, {});
}

/** Returns the paths with another one first. */
export function withPath(paths: readonly GivenPath[], path: GivenPath): readonly GivenPath[] {
  return [path, ...paths.filter(({ table }) => !equal(table, path.table))].slice(0, PATHS);
}

/**
 * Returns a name such as `my-star`, `my-star, edited` or `drawn path`; empty for the scenario's own
 * path, and for one of the kinds identified by their numbers.
 */
export function pathName(
  trajectory: Trajectory | undefined,
  own: Trajectory | undefined,
  named: readonly GivenPath[],
): string {
  if (!trajectory || equal(trajectory, own)) return '';
  const drawn = trajectory.kind === 'path' ? 'drawn path' : '';
  // The server adds what a table leaves to its defaults.
  const same = named.find(({ table }) =>
    Object.entries(table).every(([key, value]) => equal(trajectory[key], value)),
  );
  if (same) return same.name === '' ? drawn : same.name;
  const last = named.find(({ table }) => table.kind === trajectory.kind);
  return last === undefined || last.name === '' ? drawn : `${last.name}, edited`;
}
