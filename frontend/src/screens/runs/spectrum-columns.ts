/** Which spectra a run has: a quantity of each of its first two variants, or a column they share. */

import type { RunDetail } from '../../app/api/types';

export interface Quantity {
  /** Such as `x following error`. */
  name: string;
  columns: string[];
}

const VARIANTS = 2;

/** Returns the quantities of a run, following errors first. */
export function quantitiesOf({ columns, variants }: RunDetail): Quantity[] {
  const shown = new Set(variants.slice(0, VARIANTS));
  const found = new Map<string, string[]>();
  for (const { name = '' } of columns) {
    const [, variant, rest] = /^([A-Z])\.(.+)$/.exec(name) ?? [];
    if (variant !== undefined && !shown.has(variant)) continue;
    const quantity = (rest ?? name).replaceAll(/[._]/g, ' ');
    found.set(quantity, [...(found.get(quantity) ?? []), name]);
  }
  const all = [...found].map(([name, own]) => ({ name, columns: own }));
  const errors = all.filter(({ name }) => name.endsWith('following error'));
  return [...errors, ...all.filter((each) => !errors.includes(each))];
}
