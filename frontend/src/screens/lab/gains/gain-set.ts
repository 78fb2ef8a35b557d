/** What can be kept as a named set of gains, and what it achieved. */

import { at, equal } from '../../../app/api/scenario-paths';
import { AXES, type Changes, type GainSet, type Scenario } from '../../../app/api/types';
import { digits, quantity, type Quantity } from '../../../ui/units';
import { FILTER, filterPath, FILTERS, gainPath, NOTCH, notchPath, SWITCHES } from './gains';

/** Everything of the controllers that the panel can change. */
function tunables(scenario: Scenario): string[] {
  return Object.keys(scenario.variants).flatMap((variant) => [
    ...AXES.flatMap((axis) => [
      gainPath(variant, axis, 'k_p'),
      gainPath(variant, axis, 'k_d'),
      ...NOTCH.map((what) => notchPath(variant, axis, what)),
      ...FILTERS.flatMap((name) => FILTER.map((what) => filterPath(variant, axis, name, what))),
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
