/** Warnings of gains that are chosen although their loop is unstable, with the gain that is wrong. */

import type { Axis } from '../../app/api/types';
import type { LoopAt, LoopFigures } from '../../parts/loop/loops.svelte';
import { digits } from '../../ui/units';

/** Returns what is wrong with chosen gains, and at which gain the loop would be stable. */
export function limitWarnings(figures: LoopFigures | null, axis: Axis): string[] {
  if (!figures) return [];
  return [figures, figures.standstill].flatMap((loop) => warning(loop, axis));
}

function warning(figures: LoopAt, axis: Axis): string[] {
  if (figures.stable) return [];
  const edges = [
    ['k_p', figures.k_p_limit, 'N/mm'] as const,
    ['k_d', figures.k_d_limit, 'N s/mm'] as const,
  ].flatMap(([gain, limit, unit]) =>
    limit === null ? [] : [`${gain} = ${digits(limit / 1e3, 4)} ${unit}`],
  );
  const nearest =
    edges.length > 0 ? ` The stability boundary, each gain moved alone: ${edges.join(', ')}.` : '';
  const where = figures.velocity === 0 ? ' at standstill' : '';
  return [`The chosen gains of ${axis} are unstable${where}.${nearest}`];
}
