/** The versions of a law of one's own: what is said of them, and old against new. */

import { at } from '../../../app/api/scenario-paths';
import type { Changes, LawEntry, Scenario, Value } from '../../../app/api/types';
import { digits } from '../../../ui/units';
import { toChange } from './gain-set';

/** What tells controllers from each other for people only. */
const NAMES: ReadonlySet<string> = new Set(['name', 'description']);

/** `It costs 42 ns in a tick, 0.0084 % of the control period.` */
export function costText({ ns, share }: NonNullable<LawEntry['cost']>): string {
  if (ns === 0) return 'It costs too little to be measured.';
  const part = `${digits(100 * share, 2)} % of the control period`;
  return `It costs ${digits(ns, 2)} ns in a tick, ${part}.`;
}

/** `Version 3 of 4 runs; the file is newer`; empty where there is one version only. */
export function versionText({ version, versions, newer, problem }: LawEntry): string {
  const later = newer && problem === '' ? '; the file is newer' : '';
  if (versions === 1 && later === '') return '';
  return `Version ${version} of ${versions} runs${later}.`;
}

/** The law that goes back by a key: one in use that has other versions, of the last variant first. */
export function lawWithVersions(
  laws: readonly LawEntry[],
  scenario: Scenario,
): LawEntry | undefined {
  const used = Object.values(scenario.variants).map(
    ({ controller }) => controller.compensation.law,
  );
  return used
    .reverse()
    .map((name) =>
      laws.find((law) => name === law.name || (law.before !== '' && name === law.before)),
    )
    .find((law) => law !== undefined && law.versions > 1);
}

/**
 * Returns what makes the first of two variants the second with the version before of its law; both
 * have the controller of `from`.
 */
export function oldAgainstNew(
  scenario: Scenario,
  [old, now]: readonly [string, string],
  from: string,
  law: Pick<LawEntry, 'name' | 'before'>,
): Changes {
  const source = at(scenario, `variants.${from}.controller`);
  const both = [old, now].flatMap((variant) =>
    leaves(source).map(([path, value]) => [`variants.${variant}.controller.${path}`, value]),
  );
  return toChange(scenario, {
    ...(Object.fromEntries(both) as Changes),
    [`variants.${old}.controller.compensation.law`]: law.before,
    [`variants.${now}.controller.compensation.law`]: law.name,
  });
}

/** Every value of a table with its path. */
function leaves(table: unknown): [string, Value][] {
  if (typeof table !== 'object' || table === null) return [];
  return Object.entries(table)
    .filter(([name]) => !NAMES.has(name))
    .flatMap(([name, value]: [string, unknown]): [string, Value][] => {
      if (typeof value !== 'object' || value === null || Array.isArray(value)) {
        return [[name, value as Value]];
      }
      return leaves(value).map(([path, each]) => [`${name}.${path}`, each]);
    });
}
