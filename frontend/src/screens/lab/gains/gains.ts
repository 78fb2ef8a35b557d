/** Paths of gains, notches and switches. */

import { numberAt } from '../../../app/api/scenario-paths';
import { AXES, type Axis, type Changes, type Scenario, type Value } from '../../../app/api/types';
import { entryOf } from '../../../app/fields/fields.svelte';
import type { SliderScale } from '../../../ui/log-slider';

export type Gain = 'k_p' | 'k_d';

/** Returns the range of a gain's slider. */
export function scaleOf(path: string): SliderScale {
  const [least, most] = entryOf(path)?.usual ?? [Number.NaN, Number.NaN];
  return { least, most };
}

/** What a notch has; its gain is that at its frequency, and 1 is no notch. */
export const NOTCH = ['frequency', 'damping', 'gain'] as const;

/** Switches by their paths below the controller. */
export const SWITCHES = ['compensation.enabled', 'feedforward', 'disturbance_observer.enabled'];

export function gainPath(variant: string, axis: Axis, gain: Gain): string {
  return `variants.${variant}.controller.${axis}.${gain}`;
}

export function notchPath(variant: string, axis: Axis, what: (typeof NOTCH)[number]): string {
  return `variants.${variant}.controller.${axis}.notch.${what}`;
}

/** The filters after the notch, and what each has; one whose poles are at 0 Hz is none. */
export const FILTERS = ['filter_1', 'filter_2', 'filter_3'] as const;
export const FILTER = [
  'zeros_frequency',
  'zeros_damping',
  'poles_frequency',
  'poles_damping',
] as const;

export function filterPath(
  variant: string,
  axis: Axis,
  filter: (typeof FILTERS)[number],
  what: (typeof FILTER)[number],
): string {
  return `variants.${variant}.controller.${axis}.${filter}.${what}`;
}

/** Returns how many of those filters act, on both axes. */
export function filters(scenario: Scenario | null, variant: string): number {
  const paths = AXES.flatMap((axis) =>
    FILTERS.map((filter) => filterPath(variant, axis, filter, 'poles_frequency')),
  );
  return paths.filter((path) => numberAt(scenario, path) > 0).length;
}

/** Whether a notch acts on an axis of a variant. */
export function notched(scenario: Scenario | null, variant: string, axis: Axis): boolean {
  return numberAt(scenario, notchPath(variant, axis, 'gain')) < 1;
}

/** Returns what adds notches to both axes where none is, or removes those that are. */
export function switchNotch(scenario: Scenario | null, variant: string, on: boolean): Changes {
  const others = AXES.filter((axis) => notched(scenario, variant, axis) !== on);
  return Object.fromEntries(
    others.map((axis) => {
      const path = notchPath(variant, axis, 'gain');
      const entry = entryOf(path);
      return [path, (on ? entry?.example : entry?.default) as Value];
    }),
  );
}
