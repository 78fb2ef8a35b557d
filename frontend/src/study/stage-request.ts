/** Stages in the Lab what a study was asked for, with what it found. */

import { equal } from '../app/api/scenario-paths';
import type { Changes } from '../app/api/types';
import type { ScenarioSource } from '../app/jobs/job-request';
import { app } from '../app/store.svelte';

/** Opens the scenario of a job's request, unless it is there, and stages its changes with others. */
export async function stageRequest(request: object, changes: Changes): Promise<void> {
  const { scenario = 'circle', set = {} } = request as Partial<ScenarioSource>;
  if (!equal(scenario, app.session.info?.scenario)) await app.loadScenario(scenario);
  if (typeof set['plant'] === 'string') await app.catalogue.resolvePlant(set['plant']);
  app.setMode('whatif');
  app.whatIfChanges.replace({ ...set, ...changes });
}
