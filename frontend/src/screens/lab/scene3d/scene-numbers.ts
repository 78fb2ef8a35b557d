/** Numbers and words beside the 3-D view. */

import { minus } from '../../../ui/units';

type Three = readonly (number | null)[];

/** Movers of one axis, as the server tells them. */
export interface Movers {
  thrust: number | null;
  current: Three;
  phase_thrust: Three;
  phase_normal_force: Three;
  to_aligned: Three;
}

export interface PhaseRow {
  phase: 'a' | 'b' | 'c';
  current: number | null;
  thrust: number | null;
  normal: number | null;
  toAligned: number | null;
}

/** A, from where on a phase counts as carrying current. */
const CARRIES = 0.05;
/** N, below which a thrust is too small for a share of it. */
const LEAST = 0.05;

export function sectionRows(movers: Movers): PhaseRow[] {
  return (['a', 'b', 'c'] as const).map((phase, k) => ({
    phase,
    current: movers.current[k] ?? null,
    thrust: movers.phase_thrust[k] ?? null,
    normal: movers.phase_normal_force[k] ?? null,
    toAligned: movers.to_aligned[k] ?? null,
  }));
}

/** Returns the share of a phase in the thrust of its axis. */
export function shareText(thrust: number | null, total: number | null): string {
  if (thrust === null || total === null || Math.abs(total) < LEAST) return '–';
  return minus(`${((100 * thrust) / total).toFixed(0)} %`);
}

/** Returns which phase pulls most, to which side, and why. */
export function whyText(movers: Movers, machine: string, axis: string): string {
  const rows = sectionRows(movers).filter(({ current }) => Math.abs(current ?? 0) > CARRIES);
  const size = ({ thrust }: PhaseRow) => Math.abs(thrust ?? 0);
  const [first] = rows.sort((one, other) => size(other) - size(one));
  if (!first || size(first) < LEAST) return `No phase of ${machine} ${axis} pulls.`;
  const away = Math.abs(first.toAligned ?? 0) * 1e3;
  const side = (first.thrust ?? 0) > 0 ? 'right' : 'left';
  return (
    `Phase ${first.phase} pulls most, to the ${side}: its teeth stand ${away.toFixed(2)} mm ` +
    `from those of the stator on that side, and its current draws them over.`
  );
}
