import { expect, it } from 'vitest';
import type { ChannelComparison } from '../../app/api/types';
import { USUAL } from '../../parts/compare/compare-request';
import { howJudged, movingErrors, REFERENCES, whyNotJudged } from './last-run';

const RUN = {
  state: 'complete',
  reason: '',
  stopped: '',
  stopped_at: null,
  duration: 10,
  scenario_document: { name: 'circle' },
} as const;

it('a run to its end is judged, another one says why not', () => {
  expect(whyNotJudged(RUN)).toBe('');
  expect(whyNotJudged({ ...RUN, state: 'recording' })).toBe('It is being recorded.');
  expect(whyNotJudged({ ...RUN, scenario_document: null })).toContain('has no scenario');
  expect(whyNotJudged({ ...RUN, state: 'partial', reason: 'the disk was full' })).toBe(
    'Its record is incomplete: the disk was full.',
  );
  expect(whyNotJudged({ ...RUN, duration: 0.02 })).toMatch(/^Too short: 0\.02(00)? s recorded/);
});

it('a stop has its cause and time before anything else that is amiss', () => {
  const stopped = { ...RUN, stopped_at: 4.2, duration: 0.01 } as const;
  expect(whyNotJudged({ ...stopped, stopped: 'STOP' })).toMatch(/^Stopped at 4\.2 s by STOP\. /);
  expect(whyNotJudged({ ...stopped, stopped: 'STO active', state: 'partial' })).toMatch(
    /^Fault at 4\.2 s: STO active\. /,
  );
});

const channel = (name: string, range: number | null, at: object | null = { time: 0 }) =>
  ({ name, range, at }) as unknown as ChannelComparison;
const references = (x: number | null, y: number | null) => ({
  channels: [channel(REFERENCES[0] ?? '', x), channel(REFERENCES[1] ?? '', y)],
});
const judged = {
  channels: ['A.y.force_command', 'A.x.following_error', 'A.y.following_error'].map((name) =>
    channel(name, 1e-6),
  ),
};
const names = (x: number | null, y: number | null) =>
  movingErrors(references(x, y), judged).map(({ name }) => name);

it('following errors are drawn of the axes that move', () => {
  expect(names(0.06, 0.06)).toEqual(['A.x.following_error', 'A.y.following_error']);
  expect(names(0, 0.06)).toEqual(['A.y.following_error']);
  expect(names(0.06, 1e-9)).toEqual(['A.x.following_error']);
});

it('an axis whose reference is unknown is drawn, an error without a common value is not', () => {
  expect(names(null, 0)).toEqual(['A.x.following_error']);
  const empty = { channels: [channel('A.x.following_error', null, null)] };
  expect(movingErrors(references(0.06, 0.06), empty)).toEqual([]);
});

it('a run is judged from where its metrics begin, else over all of it', () => {
  expect(howJudged({ result: { window: { start: 0.25, end: 4.25 } } })).toEqual({
    ...USUAL,
    start: 0.25,
  });
  expect(howJudged({ result: {} })).toEqual(USUAL);
});
