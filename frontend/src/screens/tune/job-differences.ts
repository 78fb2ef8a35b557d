/** Whether what a job found is of the loop that is looked at now: same motor, motion and controller. */

import { at, difference, equal } from '../../app/api/scenario-paths';
import type { Scenario } from '../../app/api/types';

/** What can be another one. */
export type Other = 'motor' | 'load' | 'motion' | 'controller' | 'gains';

/** What decides a loop, and what the cost over gains. */
export const LOOP: readonly Other[] = ['motor', 'load', 'controller', 'gains'];
export const MAP: readonly Other[] = ['motor', 'load', 'motion', 'controller'];

/** Lists what differs between the whole scenario of a job and the present one. */
export function othersOf(then: Scenario, now: Scenario, variant: string): Set<Other> {
  const others = new Set<Other>();
  if (!samePlant(then, now)) others.add('motor');
  if (!equal(then.load, now.load)) others.add('load');
  if (!equal(then.trajectory, now.trajectory)) others.add('motion');
  const path = `variants.${variant}`;
  const [a, b] = [at(then, path), at(now, path)];
  if (typeof a !== 'object' || typeof b !== 'object' || a === null || b === null) {
    return others.add('controller');
  }
  for (const { path: changed } of difference(a, b)) {
    others.add(/\.k_[pd]$/.test(changed) ? 'gains' : 'controller');
  }
  return others;
}

/** A motor given by name only is compared by name. */
function samePlant({ plant: a }: Scenario, { plant: b }: Scenario): boolean {
  const bare = [a, b].some((plant) => Object.keys(plant).length === 1);
  return bare ? a.name === b.name : equal(a, b);
}

const WORDS: readonly [Other, string][] = [
  ['motor', 'another motor'],
  ['load', 'another load'],
  ['motion', 'another motion'],
  ['controller', 'another controller'],
  ['gains', 'other gains'],
];

/** Writes of what a job was, as far as it matters: "another motor (matched) and other gains". */
export function otherWords(
  then: Scenario,
  now: Scenario,
  variant: string,
  matter: readonly Other[],
): string {
  const others = othersOf(then, now, variant);
  const same = then.plant.name === now.plant.name;
  const words = WORDS.flatMap(([other, word]) => {
    if (!others.has(other) || !matter.includes(other)) return [];
    if (other !== 'motor') return [word];
    return [
      same
        ? `the motor ${then.plant.name} with other numbers than now`
        : `${word} (${then.plant.name})`,
    ];
  });
  return words.join(' and ');
}

export type WhichLoop = 'present' | 'chosen';

/** Returns of which of the two loops a job was; if of neither, what it was of, beside the likest. */
export function loopOf(
  then: Scenario,
  present: Scenario,
  chosen: Scenario | null,
  variant: string,
): { of: WhichLoop | null; reason: string } {
  const differs = (whole: Scenario) =>
    LOOP.filter((other) => othersOf(then, whole, variant).has(other)).length;
  const likest = chosen && differs(chosen) < differs(present) ? chosen : present;
  if (differs(likest) === 0) return { of: likest === present ? 'present' : 'chosen', reason: '' };
  return { of: null, reason: `of ${otherWords(then, likest, variant, LOOP)}` };
}
