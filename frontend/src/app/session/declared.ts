/** Scenarios that the page keeps, once laws declare other parameters. */

import { at, isTable } from '../api/scenario-paths';
import type { Scenario } from '../api/types';

/** Returns a scenario with the parameters of laws that another one has: its own values, or those. */
export function declaredAs(kept: Scenario, now: Scenario): Scenario {
  const variants = Object.entries(kept.variants).map(([name, variant]) => {
    const own: object = variant.controller.compensation;
    const other = at(now, `variants.${name}.controller.compensation`);
    if (!isTable(other)) return [name, variant];
    const compensation = Object.fromEntries(
      Object.entries(other).map(([key, value]) => [key, key in own ? own[key as never] : value]),
    );
    return [name, { ...variant, controller: { ...variant.controller, compensation } }];
  });
  return { ...kept, variants: Object.fromEntries(variants) as Scenario['variants'] };
}
