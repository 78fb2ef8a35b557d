/** Overlaid runs, which are loaded with the first of them. */

import { overlay } from '../../../parts/overlay/overlay.svelte';
import { lookOfVariant, tracesOf } from '../../../plot/run-overlay';
import type { Scope } from '../../../plot/scope-catalog';
import type { TableColumn } from '../../../scopes/CurveTable.svelte';
import { view } from '../scopes/view.svelte';

export function overlaidColumns(scopes: readonly Scope[]): TableColumn[] {
  const shown = overlay.list.filter((run) => run.shown);
  return scopes.flatMap((scope) => {
    return scope.traces.flatMap((trace) =>
      shown
        .filter((run) => tracesOf(run, scope).includes(trace))
        .map((run) => ({
          label: `${scope.title} ${trace.label} ${run.name}`,
          column: trace.column,
          unit: trace.unit ?? scope.unit,
          source: () => run.over(view.range),
          look: lookOfVariant(run, trace.column.charAt(0)),
        })),
    );
  });
}

export { overlay } from '../../../parts/overlay/overlay.svelte';
export { movers } from '../../../plot/ghost-path';
export { behind } from '../../../plot/run-overlay';
export { default as OverlaidMetrics } from './OverlaidMetrics.svelte';
export { default as OverlaidRuns } from './OverlaidRuns.svelte';
