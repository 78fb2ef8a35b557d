/** The scenario of a run, simulated anew and kept. */

import type { RunDetail } from '../../app/api/types';
import { messages } from '../../app/messages.svelte';
import { app } from '../../app/store.svelte';
import { asItRan } from './as-it-ran';

/**
 * Simulates the scenario of a run, with the changes that were made while it ran.
 *
 * @param motor name of another motor; empty: that of the run
 * @returns the run of the simulation; null where it is a job that takes its time, or failed
 */
export async function simulateRun(run: RunDetail, motor = ''): Promise<string | null> {
  let made: string | null = null;
  await app.try(async () => {
    if (!run.scenario_document) return;
    const how = motor === '' ? 'simulated' : `simulated with ${motor}`;
    const { scenario, set } = asItRan(run);
    const body = {
      scenario,
      set: motor === '' ? set : { ...set, plant: motor },
      keep: true,
      name: `${run.name.slice(0, 40)}, ${how}`,
    };
    const answer = await app.api.json('post', '/simulate', { body });
    if ('run' in answer && answer.run) made = answer.run;
    else messages.info(`It takes long: Runs has “${body.name}” when it is done.`);
  });
  return made;
}

/** The channel in which a run and its simulation are looked at first. */
export const errorOf = (run: RunDetail): string => `${run.variants[0] ?? 'A'}.x.following_error`;
