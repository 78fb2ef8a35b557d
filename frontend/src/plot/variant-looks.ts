/** How curves of the variants of a scenario look on every screen. */

import type { Look } from './types';

const LOOKS: readonly Look[] = [
  { ink: 'a' },
  { ink: 'b', marker: 'dot' },
  { ink: 'phase-a', dash: 'dash' },
  { ink: 'phase-b', dash: 'dot' },
];

/** The look of the first variant, the second and so on: markers tell B from A without colour. */
export function looksOf(variant: number): Look {
  return LOOKS[variant % LOOKS.length] as Look;
}
