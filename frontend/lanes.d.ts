/** Lane parameters of a scenario: what `make` generates from the functions of the server. */

import type { Scenario } from './src/app/api/types';

/** Hash of the model's sources. */
export const MODEL: string;
/** Names of the rows. */
export const PARAMETERS: readonly string[];
/** Laws that it has, by name: one of one's own is the server's alone. */
export const LAWS: Readonly<Record<string, unknown>>;
export const STATES: readonly string[];
export const CLOSED_FORM: number;
export const PLANT_STEP: number;

export interface Refusal {
  parameter: string;
  value: number;
  reason: string;
  limit: number;
}

/** Lane parameters of one axis of a variant; undefined where a table decides. */
export function rows(scenario: Scenario, variant: string, axis: string): (number | undefined)[];

/** Why a law is unstable by itself with an axis of the model. */
export function refusal(compensation: object, model: object): Refusal | null;
