/** What a job was asked for, as its report says. */

import { equal, withChanges } from '../api/scenario-paths';
import type { Changes, Scenario, Value } from '../api/types';

/** A scenario and changes to it. */
export interface Source {
  scenario: Scenario;
  set: Changes;
}

/** Shipped parts, by `path=name`. */
type Parts = Readonly<Record<string, Value>>;

/** Returns the source of a job's request; null where another program asked by a scenario's name. */
export function sourceOf({ scenario, set = {} }: Record<string, unknown>): Source | null {
  return typeof scenario === 'object' && scenario !== null ? ({ scenario, set } as Source) : null;
}

/** Returns a source with its changes; a part that only the server knows is left as its name. */
export function wholeOf({ scenario, set }: Source, parts: Parts): Scenario {
  const named = Object.entries(set).flatMap(([path, value]) =>
    typeof value === 'string' ? [[`${path}=${value}`, { name: value }] as const] : [],
  );
  return withChanges(scenario, set, { ...Object.fromEntries(named), ...parts });
}

/**
 * Returns the names of the settings in which a request differs from what a form asks for now.
 *
 * @param defaults what a request means that leaves a setting out
 * @param names of the settings that are compared, by their key in a request
 */
export function differing(
  request: Readonly<Record<string, unknown>>,
  now: object,
  defaults: object,
  names: Readonly<Record<string, string>>,
): readonly string[] {
  const [form, usual] = [now, defaults] as Record<string, unknown>[];
  return Object.entries(names)
    .filter(([key]) => !equal(request[key] ?? usual?.[key] ?? null, form?.[key] ?? null))
    .map(([, name]) => name);
}
