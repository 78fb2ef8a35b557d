/** Shipped scenarios as a gallery has them: by group, each with a sentence. */

import type { ScenarioEntry } from '../../../app/api/types';
import type { FinderOption } from '../../../ui/finder';
import { pretty } from '../../../ui/units';

const TABLE = 'Table 1: ';
/** Letters that are enough to say what an example shows. */
const ENOUGH = 40;

/** An example by its name: title, what it shows, and the group that it belongs to. */
export function exampleOf({
  name,
  title,
  description,
}: ScenarioEntry): Required<FinderOption<string>> {
  const text = pretty(description.replace(/\s+/g, ' ').replaceAll('`', '').trim());
  const ofTable = title.startsWith(TABLE);
  const plain = pretty(ofTable ? title.slice(TABLE.length) : title);
  return {
    value: name,
    name: plain.charAt(0).toUpperCase() + plain.slice(1),
    detail: opening(ofTable ? text.slice(TABLE.length) : text),
    title: `${name}: ${text}`,
    group: ofTable ? 'Table 1 of the paper' : 'The circle',
  };
}

/** Sentences until something is said: "As `circle`." alone says little. */
function opening(text: string): string {
  const sentences = text.split(/(?<=[.;]) (?=[A-Z])/);
  let words = '';
  for (const sentence of sentences) {
    if (words.length >= ENOUGH) break;
    words = `${words} ${sentence}`.trim();
  }
  return `${words.charAt(0).toUpperCase()}${words.slice(1)}`.replace(/;$/, '.');
}

/** Groups in the order in which they first come. */
export function grouped<T extends { group?: string }>(options: readonly T[]): [string, T[]][] {
  const groups = [...new Set(options.map(({ group = '' }) => group))];
  return groups.map((group) => [group, options.filter((each) => (each.group ?? '') === group)]);
}
