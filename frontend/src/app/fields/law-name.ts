/** What the controller of a variant does about friction, by the law that it has now. */

import { at } from '../api/scenario-paths';
import type { Scenario } from '../api/types';
import { show } from './fields.svelte';

export function lawName(scenario: Scenario | null, variant: string): string {
  const compensation = `variants.${variant}.controller.compensation`;
  const law = at(scenario, `${compensation}.law`);
  if (typeof law !== 'string') return '';
  const name = show(`${compensation}.law`, law);
  const off = law !== 'off' && at(scenario, `${compensation}.enabled`) === false;
  return off ? `${name}, switched off` : name;
}
