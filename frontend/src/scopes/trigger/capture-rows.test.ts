import { expect, it } from 'vitest';
import type { Run } from '../../app/api/types';
import { StillSource } from '../../plot/source';
import { captureGroups, glitchChannel, measuredChannel } from './capture-rows';
import type { Capture } from './captures';
import { conditionOf } from './conditions';

const PEAK = 'B.x.following_error';

function capture(tick: number, part: Partial<Capture> = {}): Capture {
  const values = Float32Array.from({ length: 10 }, (_, i) => (i === 3 ? -tick : i));
  const first = tick - 5;
  return {
    key: `capture ${tick}`,
    time: tick / 2,
    range: { from: first / 2, to: (first + 10) / 2 },
    source: new StillSource(
      first / 2,
      0.5,
      10,
      new Map([[PEAK, { minimum: values, maximum: values }]]),
    ),
    free: false,
    apart: true,
    origin: { session: 's', timeline: 0 },
    ticks: [first, first + 10],
    tick,
    run: '',
    problem: '',
    ...part,
  };
}

function kept(id: string, origin: string, trigger_tick: number, created = 0): Run {
  const figures = { origin, from_tick: trigger_tick - 5, trigger_tick };
  const capture = { ...figures, peaks: { [PEAK]: trigger_tick }, glitches: { [PEAK]: 7 } };
  const run = {
    id,
    kind: 'live',
    scenario: 'circle',
    created,
    period: 0.5,
    pinned: false,
    capture,
  };
  return run as unknown as Run;
}

const listed = {
  hits: [] as readonly Capture[],
  runs: [] as readonly Run[],
  session: 'r-now',
  subject: 'This what-if',
  peakOf: PEAK,
  glitchOf: PEAK,
  resolution: () => 0,
  now: 0,
};

it('lists captures by what they are of: this session, the newest first, then those before', () => {
  const hits = [capture(20, { run: 'r-a' }), capture(40, { problem: 'the disk is full' })];
  const runs = [kept('r-a', 'r-now', 20), kept('r-b', 'r-now', 10), kept('r-c', 'r-old', 30)];
  const groups = captureGroups({ ...listed, hits, runs });
  expect(groups.map(({ rows }) => rows.map(({ key }) => key))).toEqual([
    ['capture 40', 'capture 20', 'r-b'],
    ['r-c'],
  ]);
  const [refused, run, before] = groups[0]?.rows ?? [];
  expect(refused).toMatchObject({ state: 'refused', run: '', peak: -40, glitch: Number.NaN });
  expect(run).toMatchObject({ state: '', run: 'r-a', time: 10, peak: 20, glitch: 7 });
  expect(before).toMatchObject({ key: 'r-b', time: 5, peak: 10 });
});

it('lists hits of a record in the order of their time', () => {
  const hits = [capture(20, { apart: false }), capture(40, { apart: false })];
  const [group] = captureGroups({ ...listed, hits });
  expect(group?.title).toBe('This what-if');
  expect(group?.rows.map(({ time }) => time)).toEqual([10, 20]);
});

it('measures the channel of a level, or the error on the axis that reverses', () => {
  const columns = ['A.x.following_error', 'B.y.following_error', 'B.x.thrust'];
  const level = conditionOf('level', 'B.x.thrust');
  const reversal = conditionOf('reversal', 'A.y.following_error');
  expect(measuredChannel([reversal, level], columns)).toBe('B.x.thrust');
  expect(measuredChannel([reversal], columns)).toBe('B.y.following_error');
  expect(measuredChannel([conditionOf('mark', '')], columns)).toBe('A.x.following_error');
  expect(glitchChannel('B.x.thrust', columns)).toBe('B.x.following_error');
  expect(glitchChannel('p=B.x.thrust * 2', columns)).toBe('A.x.following_error');
});
