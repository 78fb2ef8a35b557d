/** Name of a session's path, if it is not that of its scenario. */

import { equal } from '../api/scenario-paths';
import type { Trajectory } from '../api/types';
import type { GivenPath } from './kept-sessions';

/**
 * Returns a name such as `my-star`, `my-star, edited` or `drawn path`; empty for the scenario's own
 * path, and for one of the kinds identified by their numbers.
 */
export function pathName(
  trajectory: Trajectory | undefined,
  own: Trajectory | undefined,
  given: readonly GivenPath[],
): string {
  if (!trajectory || equal(trajectory, own)) return '';
  const drawn = trajectory.kind === 'path' ? 'drawn path' : '';
  // The server adds what a table leaves to its defaults.
  const same = given.find(({ table }) =>
    Object.entries(table).every(([key, value]) => equal(trajectory[key], value)),
  );
  if (same) return same.name === '' ? drawn : same.name;
  const last = given.find(({ table }) => table.kind === trajectory.kind);
  return last === undefined || last.name === '' ? drawn : `${last.name}, edited`;
}
