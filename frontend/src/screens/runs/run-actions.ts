/** Where runs go from here: reports as files, the clipboard, behind the curves of the Lab. */

import type { RequestOf } from '../../app/api/operations';
import { errorText } from '../../app/error-text';
import { messages } from '../../app/messages.svelte';
import { app } from '../../app/store.svelte';
import { saveFile } from '../../ui/export';
import { MOST } from '../../parts/overlay/overlay-address';
import { overlay } from '../../parts/overlay/overlay.svelte';
import { screen } from '../../app/screen.svelte';
import { runs } from './runs.svelte';

/** Returns the address of the report of a run. */
export function reportOf(id: string): string {
  return `/api/v1/runs/${id}/report`;
}

/** Saves the report of a comparison, with its alignment and tolerances. */
export async function saveComparison(body: RequestOf<'/runs/compare/report'>): Promise<void> {
  try {
    const page = await app.api.bytes('/runs/compare/report', { body }, 'post');
    saveFile(`${body.a}-${body.b}.html`, 'text/html', page);
  } catch (error) {
    messages.error(errorText(error));
  }
}

export async function copied(text: string, what: string): Promise<void> {
  try {
    await navigator.clipboard.writeText(text);
    messages.info(`${what} is on the clipboard.`);
  } catch {
    messages.info(`This browser does not let the page copy. ${what}:\n${text}`, [], {
      stays: true,
    });
  }
}

export function overlaySelected(): void {
  overlayInLab(runs.selected.filter(({ deleted }) => deleted === null).map(({ id }) => id));
}

export function overlayInLab(ids: readonly string[]): void {
  if (ids.length === 0) return;
  screen.go('lab', { overlay: overlay.add(ids.slice(0, MOST)) });
  if (ids.length > MOST) messages.info(`The Lab overlays ${MOST} runs at most: the first ${MOST}.`);
}
