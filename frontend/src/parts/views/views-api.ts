/** Calls of the views, and what they are of. */

import type { paths } from '../../app/api/schema';
import type { Changes, Scenario } from '../../app/api/types';
import { app } from '../../app/store.svelte';

/** Every view of the server. */
export type ViewName = keyof paths extends infer Path
  ? Path extends `/api/v1/views/${infer Name}`
    ? Name
    : never
  : never;

/** The document of a view. */
export type DocumentOf<Name extends ViewName> =
  paths[`/api/v1/views/${Name}`]['post']['responses'][200]['content']['application/json'];

/** A kept run or a scenario, and which stretch of it, s. */
export interface Subject {
  run?: string;
  scenario?: Scenario;
  set?: Changes;
  start?: number;
  end?: number;
}

/** A test cycle of positioning; what is left out is the server's. */
export interface Cycle {
  targets?: number;
  runs?: number;
  dwell?: number;
  low?: number | null;
  high?: number | null;
}

/** Returns the question of a view, for any subject. */
export const asks =
  <Name extends ViewName>(name: Name) =>
  (body: Subject) =>
    app.api.json('post', `/views/${name as ViewName}`, { body }) as Promise<DocumentOf<Name>>;
