/**
 * What the server says, in names of our own. schema.d.ts is generated from its OpenAPI document
 * (npm run types); only where that says no more than "an object" is there more here. All is SI.
 */

import type { components } from './schema';

type Schemas = components['schemas'];

export type Axis = 'x' | 'y';
export const AXES: readonly Axis[] = ['x', 'y'];

export type Value = string | number | boolean | null | Value[] | { [key: string]: Value };

/** Dotted path to value, as in `--set`. */
export type Changes = Record<string, Value>;

/** A scenario with all names resolved; read through paths, see `at` in paths.ts. */
export interface Scenario {
  name: string;
  title: string;
  description: string;
  seed: number;
  plant: { [key: string]: Value };
  variants: Record<string, { label: string; controller: { [key: string]: Value } }>;
  trajectory: { [key: string]: Value };
  schedule?: { time: number; set: Changes }[];
}

export type ScenarioEntry = Schemas['ScenarioEntry'];
export type Parts = Schemas['Parts'];
export type Change = Schemas['Change'];
export type SessionState = Schemas['SessionInfo']['state'];

export interface SessionInfo extends Omit<Schemas['SessionInfo'], 'scenario' | 'base'> {
  scenario: Scenario;
  base: Scenario;
}

export type AxisMetrics = Schemas['AxisMetrics'];

export interface VariantMetrics extends Pick<Schemas['VariantResult'], 'contour'> {
  diverged: { time: number } | null;
  axes: Partial<Record<Axis, Partial<AxisMetrics>>>;
}

/** The part of a result document that a session's metrics share with it. */
export interface Metrics {
  window: Schemas['Window'];
  variants: Record<string, VariantMetrics>;
}

export type ProblemField = Pick<Schemas['ProblemField'], 'loc' | 'message'> &
  Partial<Schemas['ProblemField']>;

export interface Problem extends Omit<Schemas['Problem'], 'type' | 'errors'> {
  errors: ProblemField[];
}

type WithSession<T extends { session: unknown }> = Omit<T, 'session'> & { session: SessionInfo };

export type ServerMessage =
  | WithSession<Schemas['Hello']>
  | WithSession<Schemas['SessionMessage']>
  | Schemas['Subscribed']
  | Schemas['Gap']
  | Schemas['Reset']
  | Schemas['ErrorMessage'];

export type ClientMessage = Schemas['Subscribe'] | Schemas['Acknowledge'];
