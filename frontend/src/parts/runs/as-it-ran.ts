/** The scenario of a run with the changes that were made while it ran. */

import type { Changes, RunDetail, Scenario } from '../../app/api/types';

/** Events that a schedule holds. */
const MOST = 100;

export interface AsItRan {
  scenario: Scenario;
  /** Changes that held from the start. */
  set: Changes;
  /** Whether every change is in it; else none is. */
  whole: boolean;
}

/** Returns what to simulate: later changes are events of the schedule, at their ticks. */
export function asItRan({ scenario_document, events, period }: RunDetail): AsItRan {
  const scenario = scenario_document as unknown as Scenario;
  const byTick = new Map<number, Changes>();
  for (const { kind, tick, set } of events) {
    if (kind === 'change') byTick.set(tick, { ...byTick.get(tick), ...(set as Changes) });
  }
  const set = byTick.get(0) ?? {};
  byTick.delete(0);
  const made = [...byTick].map(([tick, changes]) => ({ time: tick * period, set: changes }));
  const schedule = [...(scenario.schedule ?? []), ...made];
  if (schedule.length > MOST) return { scenario, set: {}, whole: false };
  return { scenario: { ...scenario, schedule }, set, whole: true };
}
