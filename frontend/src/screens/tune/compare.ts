/** Two sets of gains on one motion: the same controller twice, A as it is, B with the chosen gains. */

import type { Changes, Scenario } from '../../app/api/types';

export interface Comparison {
  scenario: Scenario;
  set: Changes;
}

/** Returns changes of one variant as changes of others. */
function forVariants(changes: Changes, from: string, to: readonly string[]): Changes {
  const head = `variants.${from}.`;
  const own = Object.entries(changes).filter(([path]) => path.startsWith(head));
  return Object.fromEntries(
    to.flatMap((name) =>
      own.map(([path, value]) => [`variants.${name}.${path.slice(head.length)}`, value]),
    ),
  );
}

/**
 * Returns the scenario with one controller twice, A with the present gains and B with the chosen.
 *
 * Changes that hold for both, such as another motor, stay; those of other variants go with them.
 */
export function comparison(
  scenario: Scenario,
  set: Changes,
  variant: string,
  chosen: Changes,
): Comparison {
  const own = scenario.variants[variant];
  if (!own) throw new Error(`The scenario has no variant ${variant}.`);
  const shared = Object.entries(set).filter(([path]) => !path.startsWith('variants.'));
  return {
    scenario: {
      ...scenario,
      schedule: [],
      variants: { A: { ...own, label: 'present gains' }, B: { ...own, label: 'chosen gains' } },
    },
    set: {
      ...Object.fromEntries(shared),
      ...forVariants(set, variant, ['A', 'B']),
      ...forVariants(chosen, variant, ['B']),
    },
  };
}
