/** The Lab as an address: scenario with its differences and the what-if changes. */

import { difference, equal, withChanges } from './api/scenario-paths';
import type { Changes, Scenario, Value } from './api/types';
import { fromAddress } from './storage';

/** Longer addresses are cut by mail programs and refused by servers between. */
export const LINK_MAX = 6000;

type Table = { [key: string]: unknown };

export interface LinkedSession {
  scenario: string | Scenario;
  set: Changes;
  draft: Changes;
}

/**
 * Returns what differs from the shipped scenario, as it can be set; null where settings cannot say
 * it, as of a scenario with other variants.
 */
export function settingsOf(shipped: Scenario, scenario: Scenario): Changes | null {
  const changes: Changes = {};
  collect(shipped as unknown as Table, scenario as unknown as Table, '', changes);
  const again = withChanges(shipped, changes);
  return difference(again, scenario).length === 0 ? changes : null;
}

function collect(from: Table, to: Table, prefix: string, changes: Changes): void {
  for (const [key, value] of Object.entries(to)) {
    const path = prefix === '' ? key : `${prefix}.${key}`;
    const before = from[key];
    if (equal(before, value)) continue;
    if (alike(before, value)) collect(before as Table, value as Table, path, changes);
    else changes[path] = value as Value;
  }
}

/** Whether both are tables of the same fields. */
function alike(a: unknown, b: unknown): boolean {
  const tables = [a, b].every(
    (each) => typeof each === 'object' && each !== null && !Array.isArray(each),
  );
  return tables && equal(Object.keys(a as Table).sort(), Object.keys(b as Table).sort());
}

/** Writes a session into the parameters of an address. */
export function sessionParameters({ scenario, set, draft }: LinkedSession): Record<string, string> {
  const some = (changes: Changes) =>
    Object.keys(changes).length > 0 ? JSON.stringify(changes) : '';
  const named = typeof scenario === 'string';
  return {
    scenario: named ? scenario : JSON.stringify(scenario),
    set: some(set),
    draft: some(draft),
  };
}

/** Reads the session that the address describes; throws where it is damaged. */
export function linkedSession(): LinkedSession {
  const scenario = fromAddress('scenario') ?? '';
  const changes = (key: string): Changes => {
    const table: unknown = JSON.parse(fromAddress(key) || '{}');
    if (typeof table !== 'object' || table === null || Array.isArray(table)) throw new Error(key);
    return table as Changes;
  };
  return {
    scenario: scenario.startsWith('{') ? (JSON.parse(scenario) as Scenario) : scenario,
    set: changes('set'),
    draft: changes('draft'),
  };
}
