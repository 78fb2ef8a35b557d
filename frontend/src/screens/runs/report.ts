/** Reports as files: one HTML page that needs nothing else. */

import type { RequestOf } from '../../app/api/operations';
import { errorText } from '../../app/error-text';
import { messages } from '../../app/messages.svelte';
import { app } from '../../app/store.svelte';
import { saveFile } from '../../ui/save-file';

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
