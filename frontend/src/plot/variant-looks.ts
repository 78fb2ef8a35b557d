/** How curves of the variants of a scenario look on every screen. */

import type { Look } from './types';

const LOOKS: readonly Look[] = [
  { ink: 'a' },
  { ink: 'b', marker: 'dot' },
  { ink: 'phase-a', dash: 'dash' },
  { ink: 'phase-b', dash: 'dot' },
];

/** Curves of a measurement, and of what has a name instead of a letter: no variant's colour. */
const MEASURED: readonly Look[] = [
  { ink: 'phase-a' },
  { ink: 'phase-b', dash: 'dash' },
  { ink: 'phase-c', dash: 'dot' },
];

/** The letter that stands for what was measured. */
const MEASUREMENT = 'M';

/** The look of a variant by its letter, alone or among others: markers tell B from A without colour. */
export function looksOf(variant: string): Look {
  if (variant === MEASUREMENT) return MEASURED[0] as Look;
  const place = Math.max(0, (variant.codePointAt(0) ?? 65) - 65);
  if (variant.length > 1) return MEASURED[place % MEASURED.length] as Look;
  return LOOKS[place % LOOKS.length] as Look;
}
