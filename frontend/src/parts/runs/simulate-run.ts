/** Scenarios of runs and what-ifs, simulated and kept as runs. */

import type { RunDetail } from '../../app/api/types';
import { messages } from '../../app/messages.svelte';
import { app } from '../../app/store.svelte';
import { asItRan } from './as-it-ran';
import { screen } from '../../app/screen.svelte';
import { changeRun, listRuns } from './runs-api';

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
      name: `${run.name.slice(0, 80)}, ${how}`,
    };
    const answer = await app.api.json('post', '/simulate', { body });
    if ('run' in answer && answer.run) {
      made = answer.run;
      await changeRun(made, { note: noteOf(run.id, motor) });
    } else messages.info(`It takes long: Runs has “${body.name}” when it is done.`);
  });
  return made;
}

/** The note of a simulation, by which it is recognised. */
export function noteOf(run: string, motor = ''): string {
  return `Simulation of ${run}${motor === '' ? '' : ` with ${motor}`}.`;
}

/** Returns the latest simulation of a run with its own motor; null where there is none. */
export async function simulationOf(run: string): Promise<string | null> {
  const note = noteOf(run);
  const q = `kind:simulation "${note}"`;
  const { runs } = await listRuns({ q, sort: '-created', limit: 20 });
  return runs.find((each) => each.note.startsWith(note))?.id ?? null;
}

/** The channel in which a run and its simulation are looked at first. */
export const errorOf = (run: RunDetail): string => `${run.variants[0] ?? 'A'}.x.following_error`;

/** Keeps what a what-if shows as a run. */
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
