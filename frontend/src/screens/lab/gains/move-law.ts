/** Back and forward among the versions of a law, by a key. */

import { messages } from '../../../app/messages.svelte';
import { app } from '../../../app/store.svelte';
import { lawWithVersions } from './law-versions';

/** Has the version before of the law in use run, or the one after. */
export async function moveLaw(where: 'back' | 'forward'): Promise<void> {
  const { scenario } = app;
  if (!scenario) return;
  await app.try(async () => {
    const { laws } = await app.api.laws();
    const law = lawWithVersions(laws, scenario);
    if (law) await app.api.moveLaw(law.name, where);
    else messages.info('No law in use has been saved in another version.');
  });
}
