/** Which variant of 2 is compared with which of 1. */

import type { RunDetail } from '../../../app/api/types';

type Letters = Readonly<Record<string, string>>;

/** Letters of the variants that have channels; a measurement of references alone has none. */
export function lettersOf({ columns }: Pick<RunDetail, 'columns'>): string[] {
  const letters = columns.map(({ name = '' }) => /^([A-Z])\.[xy]\./.exec(name)?.[1] ?? '');
  return [...new Set(letters)].filter((letter) => letter !== '').sort();
}

/** Why no variant of 2 can be compared with one of 1; empty where one can. */
export function withoutVariants(baseline: readonly string[], candidate: readonly string[]): string {
  const without = [baseline, candidate].flatMap(({ length }, i) => (length === 0 ? [i + 1] : []));
  if (without.length === 0) return '';
  const who = without.length === 2 ? '1 and 2 have' : `${without[0]} has`;
  return `${who} no channels of a variant, so only channels of the same name are compared.`;
}

/** Whether every variant of 2 would miss its channels in 1: no letter is in both. */
export function shareNone(baseline: readonly string[], candidate: readonly string[]): boolean {
  return candidate.length > 0 && !candidate.some((letter) => baseline.includes(letter));
}

/**
 * Returns the letters after variant `own` of 2 was set against `target` of 1; null where that
 * leaves no variant of 1 for the one that was compared with it.
 */
export function withVariant(
  letters: Letters,
  own: string,
  target: string,
  baseline: readonly string[],
  candidate: readonly string[],
): Letters | null {
  const before = (letter: string) => letters[letter] ?? letter;
  const targets = new Map(candidate.map((letter) => [letter, before(letter)]));
  const other = candidate.find((letter) => letter !== own && before(letter) === target);
  targets.set(own, target);
  if (other !== undefined) {
    const taken = new Set(targets.values());
    const free = [before(own), ...baseline].find(
      (letter) => baseline.includes(letter) && !taken.has(letter),
    );
    if (free === undefined) return null;
    targets.set(other, free);
  }
  // What keeps its letter is not said.
  return Object.fromEntries([...targets].filter(([letter, mapped]) => letter !== mapped));
}

/** Returns the variants of 1 and 2 whose paths are drawn: B, else what both have; null without one. */
export function comparedVariant(
  runs: readonly Pick<RunDetail, 'columns'>[],
  letters: Letters,
): readonly [string, string] | null {
  const [one, two] = runs.map(lettersOf);
  if (!one || !two) return null;
  const pairs = two
    .map((own) => [letters[own] ?? own, own] as const)
    .filter(([target]) => one.includes(target));
  return pairs.find(([target]) => target === 'B') ?? pairs[0] ?? null;
}
