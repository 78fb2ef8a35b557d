import { expect, it } from 'vitest';
import type { SessionInfo } from '../api/types';
import { gathered, Moments } from './moments.svelte';

it('gathers the changes of a drag into one, at its end', () => {
  const drag = [1, 1.4, 1.9, 2.6].map((time, k) => ({ time, set: { k_p: k } }));
  const later = { time: 4, set: { k_d: 1 } };
  expect(gathered([...drag, later], 1)).toEqual([{ time: 2.6, set: { k_p: 3 } }, later]);
  const both = gathered(
    [
      { time: 1, set: { k_p: 1 } },
      { time: 1.5, set: { k_d: 2 } },
    ],
    1,
  );
  expect(both).toEqual([{ time: 1.5, set: { k_p: 1, k_d: 2 } }]);
});

const K_P = { k_p: 3 };

function at(tick: number, changes: { tick: number; set: object }[], timeline = 1): SessionInfo {
  return { tick, timeline, changes } as unknown as SessionInfo;
}

it('keeps what happened when it is undone, and marks the undo', () => {
  const moments = new Moments();
  moments.period = 0.0005;
  const before = at(0, []);
  const changed = at(6000, [{ tick: 6000, set: K_P }]);
  const undone = at(10_000, []);
  moments.noteChanges(before, null);
  moments.noteChanges(changed, before);
  moments.noteChanges(changed, changed);
  moments.noteChanges(undone, changed);
  moments.noteChanges(at(10_100, []), undone);
  expect(moments.changes).toEqual([
    { time: 3, set: K_P, undone: false },
    { time: 5, set: K_P, undone: true },
  ]);
  // Another beginning, another past.
  moments.noteChanges(at(0, [], 2), undone);
  expect(moments.changes).toEqual([]);
});
