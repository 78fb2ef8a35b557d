import { expect, it } from 'vitest';
import type { Replays, RunReplay } from '../../../app/api/types';
import { headlineOf, movedRows, refusedRows, searchText } from './replay-rows';

const run = (rest: Partial<RunReplay>): RunReplay => ({
  run: 'r-a',
  name: 'a',
  outcome: 'identical',
  first: null,
  samples: 0,
  change: null,
  errors: [],
  reasons: [],
  ...rest,
});
const of = (...outcomes: RunReplay['outcome'][]) => {
  const count = (outcome: string) => outcomes.filter((each) => each === outcome).length;
  const counts = { identical: count('identical'), moved: count('moved') };
  const runs = outcomes.map((outcome) => run({ outcome }));
  return headlineOf({ ...counts, not_replayable: count('not replayable'), runs } as Replays);
};

it('says in one sentence whether anything has moved', () => {
  expect(of('identical', 'identical')).toEqual({
    text: 'None has moved: 2 runs are the same to the last bit.',
    same: true,
  });
  expect(of('identical', 'not replayable').text).toBe(
    'None has moved: 1 run is the same to the last bit. 1 run cannot be simulated again.',
  );
  expect(of('moved', 'identical', 'identical')).toEqual({
    text: 'Of 3 runs 1 has moved, 2 identical.',
    same: false,
  });
  expect(of('not replayable', 'not replayable')).toEqual({
    text: 'None of the 2 runs can be simulated again.',
    same: false,
  });
  expect(of().text).toBe('The search has no runs.');
});

const still = {
  variant: 'A',
  axis: 'x',
  max_recorded: 1e-6,
  max_simulated: 1e-6,
  max_change: 0,
  rms_recorded: 1e-6,
  rms_simulated: 1e-6,
  rms_change: 0,
};
const moved = { ...still, variant: 'B', max_simulated: 1.5e-6, max_change: 0.5e-6 };
const gone = { ...still, axis: 'y', max_simulated: null, max_change: null };

it('lists the axis that changed most, one that diverged before all others', () => {
  const first = { tick: 700, time: 0.35, channel: 'A.x.thrust', unit: 'N' };
  const values = { recorded: 2, simulated: 2.5, difference: 0.5 };
  const reasons = ['other version', 'other processor'];
  const rows = movedRows({
    runs: [
      run({ outcome: 'moved', errors: [still, moved], first: { ...first, ...values }, reasons }),
      run({ outcome: 'moved', errors: [moved, gone] }),
      run({}),
    ],
  });
  expect(rows[0]).toEqual({
    id: 'r-a',
    name: 'a',
    largest: { of: 'B x', by: '+500 nm', sides: '1.000 µm → 1.500 µm' },
    rms: null,
    first: { channel: 'A.x.thrust', at: 'at 0.3500 s' },
    why: 'other version; other processor',
  });
  expect(rows[1]?.largest).toEqual({ of: 'A y', by: '', sides: '1.000 µm → diverged' });
  expect(rows).toHaveLength(2);
});

it('lists what was not simulated again with its reason', () => {
  const reasons = ['it has no scenario'];
  expect(refusedRows({ runs: [run({ outcome: 'not replayable', reasons }), run({})] })).toEqual([
    { id: 'r-a', name: 'a', why: 'it has no scenario' },
  ]);
});

it('names the search of a request', () => {
  expect([searchText({ q: '' }), searchText({ q: 'tag:rig' })]).toEqual([
    'all runs',
    'runs of tag:rig',
  ]);
});
