/** Ranges of the sliders, and what can be kept as a named set. */

import { at, equal } from '../api/paths';
import { AXES, type Axis, type Changes, type Scenario } from '../api/types';
import type { Scale } from './slider';

export type Gain = 'k_p' | 'k_d';

/** Three decades around what the paper uses: 200 to 6000 N/mm and 1.08 to 3 N s/mm. */
export const SCALES: Record<Gain, Scale> = {
  k_p: { least: 1e4, most: 1e7 },
  k_d: { least: 1e2, most: 1e5 },
};

export const LAWS = [
  { law: 'off', name: 'no compensation' },
  { law: 'lugre-observer', name: 'LuGre observer, K = 0' },
  { law: 'residual-k', name: 'K from the residual' },
  { law: 'canudas-de-wit', name: 'Canudas de Wit' },
  { law: 'published-k', name: 'K as published' },
] as const;

export interface Switch {
  /** Path below the controller. */
  path: string;
  name: string;
  meaning: string;
}

export const SWITCHES: readonly Switch[] = [
  {
    path: 'compensation.enabled',
    name: 'compensation',
    meaning: 'Add the friction estimate; off, the observer runs all the same',
  },
  {
    path: 'feedforward',
    name: 'feedforward',
    meaning: 'Add mass times the acceleration of the reference',
  },
  {
    path: 'disturbance_observer.enabled',
    name: 'DOB',
    meaning: 'Disturbance observer: add what the force balance does not explain',
  },
];

export function gainPath(variant: string, axis: Axis, gain: Gain): string {
  return `variants.${variant}.controller.${axis}.${gain}`;
}

/** Everything of the controllers that the panel can change. */
function tunables(variants: readonly string[]): string[] {
  return variants.flatMap((variant) => [
    ...AXES.flatMap((axis) => [gainPath(variant, axis, 'k_p'), gainPath(variant, axis, 'k_d')]),
    `variants.${variant}.controller.compensation.law`,
    ...SWITCHES.map(({ path }) => `variants.${variant}.controller.${path}`),
  ]);
}

/** Returns what a named set keeps of a scenario. */
export function snapshot(scenario: Scenario): Changes {
  const set: Changes = {};
  for (const path of tunables(Object.keys(scenario.variants))) {
    const value = at(scenario, path);
    if (value !== undefined) set[path] = value;
  }
  return set;
}

/** Returns only what a set would change: nothing is written that is there already. */
export function toChange(scenario: Scenario, set: Changes): Changes {
  const changes = Object.entries(set).filter(([path, value]) => {
    const now = at(scenario, path);
    return now !== undefined && !equal(now, value);
  });
  return Object.fromEntries(changes);
}
