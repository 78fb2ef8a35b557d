/** Overlays runs in the Lab. */

import { messages } from '../../app/messages.svelte';
import { MOST } from '../../parts/overlay/overlay-address';
import { overlay } from '../../parts/overlay/overlay.svelte';
import { screen } from '../../app/screen.svelte';
import { runs } from './runs.svelte';

export function overlaySelected(): void {
  overlayInLab(runs.selected.filter(({ deleted }) => deleted === null).map(({ id }) => id));
}

export function overlayInLab(ids: readonly string[]): void {
  if (ids.length === 0) return;
  screen.go('lab', { overlay: overlay.add(ids.slice(0, MOST)) });
  if (ids.length > MOST) messages.info(`The Lab overlays ${MOST} runs at most: the first ${MOST}.`);
}
