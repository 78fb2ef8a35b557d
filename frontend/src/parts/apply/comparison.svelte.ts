/** One controller twice on one motion: A as it is, B with changes, simulated side by side. */

import type { Api } from '../../app/api/client';
import { at } from '../../app/api/scenario-paths';
import type { Changes, ProblemField, Scenario } from '../../app/api/types';
import { WhatIf } from '../../app/whatif/whatif.svelte';

interface Compared {
  scenario: Scenario;
  /** Changes of the scenario that hold for both. */
  set: Changes;
  /** Variant of the controller. */
  variant: string;
  /** Changes of B alone. */
  chosen: Changes;
  /** Labels of A and B. */
  labels: readonly [string, string];
}

export class Comparison {
  /** Subject of the last comparison: a result, chosen gains. */
  of = $state.raw<unknown>(null);
  /** Reason for a missing answer. */
  problem = $state('');
  private readonly whatif: WhatIf;
  readonly waiting = $derived.by(() => this.of !== null && this.whatif.standing !== 'exact');
  readonly failed = $derived.by(() => this.of !== null && this.whatif.standing === 'failed');
  readonly metrics = $derived.by(() =>
    this.of === null || this.failed ? null : (this.whatif.answer?.result ?? null),
  );

  constructor(api: Api, problemText: (fields: readonly ProblemField[]) => string) {
    this.whatif = new WhatIf(api, (fields, detail) => {
      this.problem = problemText(fields) || detail;
    });
  }

  /** Simulates; `of` identifies what is compared. */
  run(of: unknown, compared: Compared): void {
    this.of = of;
    this.problem = '';
    this.whatif.ask({ ...twice(compared), columns: [] });
  }
}

/** Returns changes of one variant as changes of others. */
export function forVariants(changes: Changes, from: string, to: readonly string[]): Changes {
  const head = `variants.${from}.`;
  const own = Object.entries(changes).filter(([path]) => path.startsWith(head));
  return Object.fromEntries(
    to.flatMap((name) =>
      own.map(([path, value]) => [`variants.${name}.${path.slice(head.length)}`, value]),
    ),
  );
}

/** Returns the scenario with one controller twice; changes of other variants go with those. */
export function twice({ scenario, set, variant, chosen, labels }: Compared): {
  scenario: Scenario;
  set: Changes;
} {
  const own = scenario.variants[variant];
  if (!own) throw new Error(`The scenario has no variant ${variant}.`);
  const shared = Object.entries(set).filter(([path]) => !path.startsWith('variants.'));
  const [A, B] = labels.map((label) => ({ ...own, label }));
  return {
    scenario: { ...scenario, schedule: [], variants: { A, B } as Scenario['variants'] },
    set: {
      ...Object.fromEntries(shared),
      ...forVariants(set, variant, ['A', 'B']),
      ...forVariants(chosen, variant, ['B']),
    },
  };
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
