/** Changes left behind when another session replaces the present one. */

import { at, difference, equal } from '../api/scenario-paths';
import type { Changes, Scenario, Value } from '../api/types';
import { nameOf } from '../fields/fields.svelte';
import type { Own } from './kept-sessions';

/** All that it takes to go back. */
export interface ReplacedSession extends Own {
  scenario: Scenario;
  mode: 'whatif' | 'live';
  /** What-if changes before each gesture that made them, the oldest first. */
  drafts: readonly Changes[];
}

/** Names that are listed; more are counted. */
const LISTED = 3;

/** Returns the paths that were changed since the scenario was loaded, and the what-if changes. */
export function lostPaths({ base, scenario, draft }: ReplacedSession): readonly string[] {
  const changed = difference(base, scenario).map(({ path }) => path);
  return [...new Set([...changed, ...Object.keys(draft)])];
}

/** Returns of what was changed the controllers' part, as changes of another scenario. */
export function carriedGains(
  { base, scenario, draft }: ReplacedSession,
  to: Scenario | null,
): Changes {
  const changed = difference(base, scenario).map(({ path, to }) => [path, to] as const);
  const all: Changes = {
    ...Object.fromEntries(changed.filter((each): each is [string, Value] => each[1] !== undefined)),
    ...draft,
  };
  const fit = Object.entries(all).filter(([path, value]) => {
    const now = at(to, path);
    return path.startsWith('variants.') && now !== undefined && !equal(now, value);
  });
  return Object.fromEntries(fit);
}

/** Lists what paths lead to; beyond a few they are counted. */
export function listed(paths: readonly string[]): string {
  const names = paths.map((path) => nameOf(path).replace('_', ''));
  const rest = names.length - LISTED;
  return names.slice(0, LISTED).join(', ') + (rest > 0 ? ` and ${rest} more` : '');
}

/** Text of the notice on what was left behind. */
export function replacedText(left: ReplacedSession): string {
  const paths = lostPaths(left);
  const pending = Object.keys(left.draft).length;
  const changes = paths.length === 1 ? 'one change' : `${paths.length} changes`;
  const waiting = pending > 0 && pending < paths.length ? `, ${pending} of them staged` : '';
  return `${left.scenario.name} was left with ${changes}${waiting}: ${listed(paths)}.`;
}
