/** Which variants reach their limits along a path that the motor can follow. */

import { AXES, type Axis } from '../../app/api/types';
import { digits } from '../../ui/units';

interface Variant {
  diverged: unknown;
  axes: Partial<Record<Axis, { saturated_fraction?: number | null }>>;
}

/** Returns a sentence on each variant that is at a limit some of the time, or that diverges. */
export function atLimits(variants: Readonly<Record<string, Variant>>): string[] {
  return Object.entries(variants).flatMap(([name, { diverged, axes }]) => {
    if (diverged) return [`${name} diverges on this path.`];
    const shares = AXES.flatMap((axis) => {
      const share = axes[axis]?.saturated_fraction ?? 0;
      return share > 0 ? [`${digits(share * 100, 2)} % of the time on ${axis}`] : [];
    });
    return shares.length > 0
      ? [`${name} has its command or currents at a limit ${shares.join(', ')}.`]
      : [];
  });
}
