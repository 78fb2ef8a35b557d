/** A stored map in a scenario: in the plant, or in a controller's model. */

import { at } from './api/scenario-paths';
import type { Changes, Scenario } from './api/types';
import { AXES } from './api/types';

export interface Place {
  /** `plant`, or a variant's letter. */
  of: string;
  name: string;
  /** Path of its axes in the scenario. */
  path: string;
}

export function placesOf(variants: readonly string[]): Place[] {
  return [
    { of: 'plant', name: 'plant', path: 'plant' },
    ...variants.map((letter) => ({
      of: letter,
      name: `controller ${letter}`,
      path: `variants.${letter}.controller.model`,
    })),
  ];
}

/** What to change so that both axes have a map. */
export function useMap({ path }: Place, name: string): Changes {
  return Object.fromEntries(
    AXES.map((axis) => [`${path}.${axis}.force_map`, { kind: 'table', name, offset: 0, gain: 1 }]),
  );
}

/** Name of the map that a place has on both axes; empty where that is the analytic one. */
export function usedIn(scenario: Scenario | null, { path }: Place): string {
  const names = AXES.map((axis) => at(scenario, `${path}.${axis}.force_map.name`));
  return typeof names[0] === 'string' && names[0] === names[1] ? names[0] : '';
}
