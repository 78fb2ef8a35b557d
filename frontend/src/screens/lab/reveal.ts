/** Leads from a field's path to its control in the Lab. */

import { tick } from 'svelte';
import { ownerOf } from '../../app/fields/fields.svelte';
import { openController } from './gains/open-controller.svelte';
import { view } from './scopes/view.svelte';

/** Shows the control of the first of some paths that has one, and gives it the focus. */
export async function reveal(paths: readonly string[]): Promise<void> {
  view.layout.choosing = null;
  view.trigger.open = false;
  for (const path of paths) {
    const owner = ownerOf(path);
    if (openController.shown.includes(owner)) openController.choose(owner);
    await tick();
    const control = document.querySelector<HTMLElement>(`main [data-path="${CSS.escape(path)}"]`);
    if (!control) continue;
    for (
      let up = control.closest('details');
      up;
      up = up.parentElement?.closest('details') ?? null
    ) {
      up.open = true;
    }
    control.scrollIntoView({ block: 'center' });
    control.focus();
    return;
  }
}
