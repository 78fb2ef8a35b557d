/** How an overlaid run differs from what the Lab shows. */

import { difference } from '../../../app/api/scenario-paths';
import type { RunDetail, Scenario, Value } from '../../../app/api/types';
import { fieldOf, nameOf, show } from '../../../app/fields/fields.svelte';
import { KINDS } from '../../../parts/runs/run-text';

export interface Differing {
  name: string;
  /** `312 N/mm, now 200.3`. */
  text: string;
}

/** Returns the fields in which the run's scenario differs from the present one. */
export function differs(run: RunDetail, now: Scenario | null): Differing[] {
  const then = run.scenario_document;
  if (!then || !now) return [];
  return difference(then, now)
    .filter(({ path }) => path !== 'name')
    .map(({ path, from, to }) => {
      const of = (value: Value | undefined) =>
        value === undefined || value === null ? 'none' : show(path, value);
      const { unit } = fieldOf(path);
      return { name: nameOf(path), text: `${of(from)}${unit && ` ${unit}`}, now ${of(to)}` };
    });
}

/** What is said where no field differs. */
export function sameText(run: RunDetail): string {
  if (!run.scenario_document) return KINDS[run.kind];
  const changes = run.events.filter(({ kind }) => kind === 'change').length;
  const later =
    changes === 0 ? '' : `, changed ${changes === 1 ? 'once' : `${changes} times`} since 0 s`;
  return `as now${later}`;
}
