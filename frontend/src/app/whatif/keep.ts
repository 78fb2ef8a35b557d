/** Keeps what a what-if shows as a run. */

import { messages } from '../messages.svelte';
import { screen } from '../screen.svelte';
import { app } from '../store.svelte';

export async function keepShown(): Promise<void> {
  const { question } = app.whatif.answer ?? {};
  if (!question) return;
  const { scenario, set } = question;
  await app.try(async () => {
    const body = { scenario, set, keep: true };
    const answer = await app.api.json('post', '/simulate', { body });
    const run = 'run' in answer ? answer.run : null;
    const show = { name: 'Show it', run: () => screen.go('runs', run ? { run } : {}) };
    messages.info(run ? `Kept as ${run} in Runs.` : 'It takes long: Runs has it when it is done.', [
      show,
    ]);
  });
}
