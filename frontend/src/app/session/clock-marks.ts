/** What people did to the clock of a session, as marks on its time axis. */

import type { RunEvent } from '../api/types';
import { speedText } from '../../ui/units';

/** What each did at a tick, and the speed that holds from it on. */
interface Doings {
  by: Map<string, Set<string>>;
  speed: { text: string; who: string } | null;
}

/**
 * One mark a tick: the speed, and who else played, paused and reset; who does that alone need not
 * be told.
 */
export function clockMarks(
  events: readonly RunEvent[],
  other: (by: string | undefined) => string,
): { tick: number; label: string }[] {
  const ticks = new Map<number, Doings>();
  for (const { kind, tick, by, speed } of events) {
    const who = other(by);
    const doings: Doings = ticks.get(tick) ?? { by: new Map(), speed: null };
    if (who !== '' && (kind === 'play' || kind === 'pause' || kind === 'reset')) {
      doings.by.set(who, (doings.by.get(who) ?? new Set()).add(kind));
    }
    if (typeof speed === 'number') doings.speed = { text: `speed ${speedText(speed)}`, who };
    if (doings.by.size > 0 || doings.speed) ticks.set(tick, doings);
  }
  return [...ticks].map(([tick, { by, speed }]) => {
    if (speed) by.set(speed.who, (by.get(speed.who) ?? new Set()).add(speed.text));
    const labels = [...by].map(([who, words]) => [...words].join(', ') + who);
    return { tick, label: labels.join('; ') };
  });
}
