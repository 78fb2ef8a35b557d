/** The request of a job, from its report. */

import { withChanges } from '../api/scenario-paths';
import type { Changes, Scenario, Value } from '../api/types';

/** A scenario and changes to it. */
export interface ScenarioSource {
  scenario: Scenario;
  set: Changes;
}

/** Shipped parts, by `path=name`. */
type Parts = Readonly<Record<string, Value>>;

/** Returns the source of a job's request; null for a request by a scenario's name. */
export function inlineScenarioOf({
  scenario,
  set = {},
}: Record<string, unknown>): ScenarioSource | null {
  return typeof scenario === 'object' && scenario !== null
    ? ({ scenario, set } as ScenarioSource)
    : null;
}

/** Returns a source with its changes; parts not in `parts` are left as their names. */
export function wholeOf({ scenario, set }: ScenarioSource, parts: Parts): Scenario {
  const named = Object.entries(set).flatMap(([path, value]) =>
    typeof value === 'string' ? [[`${path}=${value}`, { name: value }] as const] : [],
  );
  return withChanges(scenario, set, { ...Object.fromEntries(named), ...parts });
}
