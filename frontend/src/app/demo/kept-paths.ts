/** Paths that a demo keeps: in the storage of this browser, and what ships in the folder. */

import type { Trajectory, TrajectoryEntry } from '../api/types';
import { load, recordOf, save } from '../storage';

const KEY = 'demo-paths';
type Kept = TrajectoryEntry & { trajectory: Trajectory };

const kept = () => load<Record<string, Trajectory>>(KEY, {}, recordOf({ kind: '' }));

export function listed(shipped: readonly TrajectoryEntry[]): TrajectoryEntry[] {
  const own = Object.entries(kept()).map(([name, { kind }]) => {
    return { name, shipped: false, kind: String(kind) };
  });
  return [...shipped, ...own].sort((a, b) => (a.name < b.name ? -1 : 1));
}

/** Returns a path by name; null where there is none. */
export function pathOf(name: string): Kept | null {
  const trajectory = kept()[name];
  return trajectory ? { name, shipped: false, kind: String(trajectory.kind), trajectory } : null;
}

/** Returns what is kept under a name now; null where this browser keeps nothing. */
export function keep(name: string, trajectory: Trajectory): Kept | null {
  save(KEY, { ...kept(), [name]: trajectory });
  return pathOf(name);
}

export function drop(name: string): void {
  save(KEY, Object.fromEntries(Object.entries(kept()).filter(([other]) => other !== name)));
}
