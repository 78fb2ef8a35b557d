/** How curves of the variants of a scenario look on every screen. */

import type { Look } from './types';

const LOOKS: readonly Look[] = [
  { ink: 'a' },
  { ink: 'b', marker: 'dot' },
  { ink: 'phase-a', dash: 'dash' },
  { ink: 'phase-b', dash: 'dot' },
];

/** The look of a variant by its letter, alone or among others: markers tell B from A without colour. */
export function looksOf(variant: string): Look {
  const place = Math.max(0, (variant.codePointAt(0) ?? 65) - 65);
  return LOOKS[place % LOOKS.length] as Look;
}
