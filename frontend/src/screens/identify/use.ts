/** What is found put to use: compared with the old model, and given to variants of the Lab. */

import { at } from '../../app/api/scenario-paths';
import type { Changes, Scenario, Value } from '../../app/api/types';

/** Returns changes of one variant's model as changes of others. */
export function forVariants(changes: Changes, from: string, to: readonly string[]): Changes {
  const head = `variants.${from}.`;
  const found: Changes = {};
  for (const [path, value] of Object.entries(changes)) {
    if (!path.startsWith(head)) continue;
    for (const name of to) found[`variants.${name}.${path.slice(head.length)}`] = value;
  }
  return found;
}

export interface Comparison {
  scenario: Scenario;
  set: Changes;
}

/**
 * Returns the scenario with one controller twice: A with the model as it was, B as identified.
 *
 * Changes that came with the experiment hold for both. The compensation is switched on where a
 * schedule would do so later, because the model is what is compared.
 */
export function comparison(
  scenario: Scenario,
  set: Changes,
  variant: string,
  found: Changes,
): Comparison {
  const own = scenario.variants[variant];
  if (!own) throw new Error(`The scenario has no variant ${variant}.`);
  const head = `variants.${variant}.`;
  const others = Object.entries(set).filter(([path]) => !path.startsWith('variants.'));
  const both = Object.fromEntries(Object.entries(set).filter(([path]) => path.startsWith(head)));
  const on: Changes = compensates(scenario, set, variant)
    ? { [`${head}controller.compensation.enabled`]: true }
    : {};
  return {
    scenario: {
      ...scenario,
      schedule: [],
      variants: { A: { ...own, label: 'old model' }, B: { ...own, label: 'identified' } },
    },
    set: {
      ...Object.fromEntries(others),
      ...forVariants({ ...both, ...on }, variant, ['A', 'B']),
      ...forVariants(found, variant, ['B']),
    },
  };
}

/** Whether a variant has a law that makes use of the model. */
export function compensates(scenario: Scenario, set: Changes, variant: string): boolean {
  const path = `variants.${variant}.controller.compensation.law`;
  const law: Value | undefined = set[path] ?? at(scenario, path);
  return law !== 'off';
}

/** Returns the present values of what changes would change. */
export function present(scenario: Scenario, changes: Changes): Changes {
  return Object.fromEntries(
    Object.keys(changes).flatMap((path) => {
      const value = at(scenario, path);
      return value === undefined ? [] : [[path, value]];
    }),
  );
}
