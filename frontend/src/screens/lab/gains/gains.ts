/** Paths of gains, notches and switches, and what can be kept as a named set. */

import { at, equal, numberAt } from '../../../app/api/scenario-paths';
import {
  AXES,
  type Axis,
  type Changes,
  type GainSet,
  type Scenario,
  type Value,
} from '../../../app/api/types';
import { entryOf, served } from '../../../app/fields/fields.svelte';
import type { SliderScale } from '../../../ui/log-slider';
import { digits, quantity, type Quantity } from '../../../ui/units';

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

/** Paths of the parameters that a variant's law, or its sharing function, uses. */
export function lawParameters(
  scenario: Scenario | null,
  variant: string,
  part: 'compensation' | 'sharing' = 'compensation',
): string[] {
  const law = String(at(scenario, `variants.${variant}.controller.${part}.law`) ?? '');
  return Object.keys(served.scenario.fields)
    .filter((path) => path.startsWith(`variants.*.controller.${part}.`))
    .map((path) => path.replace('*', variant))
    .filter((path) => entryOf(path)?.used_with?.includes(law));
}

/** Everything of the controllers that the panel can change. */
function tunables(scenario: Scenario): string[] {
  return Object.keys(scenario.variants).flatMap((variant) => [
    ...AXES.flatMap((axis) => [
      gainPath(variant, axis, 'k_p'),
      gainPath(variant, axis, 'k_d'),
      ...NOTCH.map((what) => notchPath(variant, axis, what)),
    ]),
    ...[
      'compensation.law',
      ...SWITCHES,
      'disturbance_observer.bandwidth',
      ...Object.keys(scenario.variants[variant]?.controller.sharing ?? {}).map(
        (name) => `sharing.${name}`,
      ),
    ].map((path) => `variants.${variant}.controller.${path}`),
  ]);
}

/** Returns what a named set keeps of a scenario. */
export function snapshot(scenario: Scenario): Changes {
  const set: Changes = {};
  for (const path of tunables(scenario)) {
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

/** Returns a name that the server takes: what it does not know becomes a hyphen. */
export function setName(text: string): string {
  const known = text.trim().replace(/[^A-Za-z0-9 ._,()+-]/g, '-');
  return known.replace(/^[^A-Za-z0-9]+/, '').slice(0, 60);
}

export interface Figure extends Quantity {
  label: string;
}

/** Returns what a set achieved when it was saved: of each variant the errors and phase margins. */
export function achieved(set: GainSet): { variant: string; figures: Figure[] }[] {
  const names = [...Object.keys(set.metrics), ...Object.keys(set.margins)];
  const variants = [...new Set(names.map((name) => name.split('.')[0] ?? ''))].sort();
  return variants.map((variant) => {
    const figures: Figure[] = [];
    for (const axis of AXES) {
      const error = set.metrics[`${variant}.${axis}.max_abs_following_error`];
      if (error !== undefined) figures.push({ label: `max |e_${axis}|`, ...quantity(error, 'm') });
    }
    for (const axis of AXES) {
      const margin = set.margins[`${variant}.${axis}`]?.phase_margin ?? null;
      if (margin !== null) figures.push({ label: `PM ${axis}`, ...degrees(margin) });
    }
    return { variant, figures };
  });
}

function degrees(angle: number): Quantity {
  return { number: digits((angle * 180) / Math.PI), unit: '°' };
}

/** Returns day and minute, as 2026-11-22 14:05. */
export function savedOn(seconds: number): string {
  const when = new Date(seconds * 1e3);
  const two = (n: number) => String(n).padStart(2, '0');
  const day = [when.getFullYear(), two(when.getMonth() + 1), two(when.getDate())].join('-');
  return `${day} ${two(when.getHours())}:${two(when.getMinutes())}`;
}
