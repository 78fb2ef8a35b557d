/** Columns of overlaid runs in the table of the scopes. */

import { overlay } from '../../../app/overlay/overlay.svelte';
import { tracesOf } from '../../../plot/ghosts';
import { SCOPES, type Scope } from '../../../plot/scope-catalog';
import type { TableColumn } from '../scopes/CurveTable.svelte';
import { view } from '../scopes/view.svelte';

export function overlaidColumns(scopes: readonly Scope[]): TableColumn[] {
  return overlay.list
    .filter(({ shown }) => shown)
    .flatMap((run) =>
      scopes.flatMap((scope) => {
        const short = SCOPES.find(({ id }) => id === scope.id)?.short ?? '';
        return tracesOf(run, scope).map(({ label, column }) => ({
          label: `${short} ${label} ${run.name}`,
          column,
          unit: scope.unit,
          source: () => run.over(view.range()),
        }));
      }),
    );
}
