/** What people did during a session: to its parameters, its mover and its clock, by time. */

import type { RunEvent, SessionInfo } from '../api/types';

/** A change of parameters, or that it was taken back. */
export interface Made {
  time: number;
  set: object;
  undone: boolean;
  by: string;
}

/** Changes by the same person that follow each other within `gap`, s, as one, at the last of them. */
export function gathered(changes: readonly Made[], gap: number): Made[] {
  const moments: Made[] = [];
  for (const change of changes) {
    const last = moments.at(-1);
    const alike = last?.by === change.by && last.undone === change.undone;
    if (last && alike && change.time - last.time < gap) {
      moments[moments.length - 1] = { ...change, set: { ...last.set, ...change.set } };
    } else moments.push(change);
  }
  return moments;
}

export class Moments {
  /** Control period, s; 0 until the stream has sent it. */
  period = $state(0);
  events = $state.raw<readonly RunEvent[]>([]);

  readonly changes = $derived.by((): readonly Made[] =>
    this.of('change').map(({ time, event: { set = {}, undo, by } }) => {
      return { time, set, undone: undo, by };
    }),
  );

  /** Events of a kind, by time, s. */
  of(kind: RunEvent['kind']): { time: number; event: RunEvent }[] {
    if (this.period === 0) return [];
    return this.events
      .filter((event) => event.kind === kind)
      .map((event) => ({ time: event.tick * this.period, event }));
  }
}

/** The reset that has come between two accounts of a session, if one has. */
export function newReset(before: SessionInfo, now: SessionInfo): RunEvent | null {
  const [first] = now.events;
  return before.timeline !== now.timeline && first?.kind === 'reset' ? first : null;
}

/** The latest event of a law's file that has come between two accounts of a session, if one has. */
export function newLaw(before: SessionInfo, now: SessionInfo): RunEvent | null {
  const latest = ({ events }: SessionInfo) => events.filter(({ kind }) => kind === 'law').at(-1);
  const law = latest(now);
  return law && law.at !== latest(before)?.at ? law : null;
}

/** The stop that has come between two accounts of a session, if one has. */
export function newStop(before: SessionInfo, now: SessionInfo): RunEvent | null {
  const stop = now.events.at(-1);
  if (stop?.kind !== 'stop') return null;
  const known = before.timeline === now.timeline && before.events.at(-1)?.kind === 'stop';
  return known ? null : stop;
}
