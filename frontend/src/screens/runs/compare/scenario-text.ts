/** What was set differently in two runs, in words. */

import { difference } from '../../../app/api/scenario-paths';
import type { Run, RunDetail, RunDifference, Value } from '../../../app/api/types';
import { differing, KINDS, type Differing } from '../../../parts/runs/run-text';

/** Beyond these a list of runs has no more differences of one. */
const LISTED = 50;

/** Returns what differs from 1 in 2, and in words why there may be more to it. */
export function setDifferently(
  one: RunDetail,
  two: RunDetail,
): { fields: Differing[]; notes: string[] } {
  const [a, b] = [one.scenario_document, two.scenario_document];
  const notes = [one, two].flatMap((run, i) => notesOf(run, i + 1));
  if (!a || !b) return { fields: [], notes };
  const fields = difference(a, b).map(({ path, from, to }) =>
    differing({ path, shipped: (from ?? null) as Value, value: (to ?? null) as Value }),
  );
  if (one.version !== two.version) notes.push(`version ${one.version} → ${two.version}`);
  else if (one.model !== two.model) notes.push('other sources of the model');
  return { fields, notes };
}

function notesOf(run: RunDetail, number: number): string[] {
  if (!run.scenario_document) return [`${number} is ${KINDS[run.kind]}, without a scenario`];
  const counts = (['change', 'push', 'stop'] as const).flatMap((kind) => {
    const count = run.events.filter((event) => event.kind === kind).length;
    const name = { change: 'changes', push: 'pushes', stop: 'STOP' }[kind];
    return count === 0 ? [] : [kind === 'stop' ? name : `${name}: ${count}`];
  });
  return counts.length === 0 ? [] : [`while ${number} ran: ${counts.join(', ')}`];
}

/**
 * Returns in what a run of a list differs from the baseline, by what each differs from its shipped
 * scenario; null where a list does not show that: another scenario, or too many differences.
 */
export function differsFrom(baseline: Run, run: Run): RunDifference[] | null {
  const both = [baseline, run];
  if (baseline.scenario !== run.scenario || run.scenario === '') return null;
  if (both.some(({ differences }) => differences.length >= LISTED)) return null;
  const [before, after] = both.map(
    ({ differences }) => new Map(differences.map((each) => [each.path, each])),
  ) as [Map<string, RunDifference>, Map<string, RunDifference>];
  return [...new Set([...after.keys(), ...before.keys()])].flatMap((path) => {
    const [old, now] = [before.get(path), after.get(path)];
    const shipped = old ? old.value : now?.shipped;
    const value = now ? now.value : old?.shipped;
    return JSON.stringify(shipped) === JSON.stringify(value)
      ? []
      : [{ path, shipped: shipped ?? null, value: value ?? null }];
  });
}
