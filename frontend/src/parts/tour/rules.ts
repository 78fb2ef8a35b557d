/** What a step outlines, and what of a draft is its own. */

import { equal } from '../../app/api/scenario-paths';
import type { Changes } from '../../app/api/types';
import type { Screen } from '../../app/screen.svelte';
import type { Mode } from '../../app/store.svelte';

export interface Target {
  /** The screen that the step is on. */
  screen: Screen;
  /** Selector of what is outlined there; on other screens it is the way to it. */
  targets: string;
}

/** What was staged for a step, and what stood there before. */
export interface Staged {
  changes: Changes;
  before: Changes;
  mode: Mode;
}

/** Returns a draft without what the tour staged, unless somebody has changed it since. */
export function takenBack(draft: Changes, { changes, before }: Omit<Staged, 'mode'>): Changes {
  const mine = Object.keys(changes).filter((path) => equal(draft[path], changes[path]));
  const others = Object.entries(draft).filter(([path]) => !mine.includes(path));
  const earlier = Object.entries(before).filter(([path]) => mine.includes(path));
  return Object.fromEntries([...others, ...earlier]);
}

/** Selector of what is to be outlined now: what the step speaks of, or the way to its screen. */
export function targetsOf({ screen, targets }: Target, current: Screen): string {
  return screen === current ? targets : `nav a[href="?screen=${screen}"]`;
}
