/** Calls of the views, and what they are of. */

import type { components } from '../api/schema';
import type { Changes, Scenario } from '../api/types';
import { app } from '../store.svelte';

export type Ballbar = components['schemas']['Ballbar'];

/** A kept run or a scenario, and which stretch of it, s. */
export interface Subject {
  run?: string;
  scenario?: Scenario;
  set?: Changes;
  start?: number;
  end?: number;
}

export const viewBallbar = (body: Subject): Promise<Ballbar> =>
  app.api.json('post', '/views/ballbar', { body });
