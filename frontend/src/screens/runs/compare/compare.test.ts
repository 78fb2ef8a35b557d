import { expect, it } from 'vitest';
import type { ChannelComparison, Comparison, Run, RunDetail } from '../../../app/api/types';
import {
  bodyOf,
  commandOf,
  curlOf,
  USUAL,
  howOf,
  lastBeforeStop,
  patternsOf,
  swapped,
  type How,
} from '../../../parts/compare/compare-request';
import {
  comparedVariant,
  lettersOf,
  shareNone,
  withoutVariants,
  withVariant,
} from './compared-variants';
import {
  beyondText,
  countsOf,
  csvOf,
  headlineOf,
  listed,
  placeText,
  reasonText,
  sortedBy,
  toleranceText,
} from '../../../parts/compare/channel-verdicts';
import { ComparisonWindow } from '../../../parts/compare/comparison-window';
import { differsFrom, setDifferently } from './scenario-text';

const HOW: How = {
  align: 'reference',
  offset: 0,
  samples: 'intersection',
  tolerance: { absolute: 1e-9, relative: 0.01, time: 0.002 },
  exact: false,
  rules: { "*.x.it's": { absolute: 1e-6, relative: 0, time: 0, interpolation: 'hold' } },
  start: 0.5,
  end: 10,
  only: ['B.*'],
  variants: { M: 'B' },
};

it('an address brings back what was asked for, and nonsense asks for what is usual', () => {
  expect(howOf(JSON.stringify(bodyOf(HOW)))).toEqual(HOW);
  expect(bodyOf(USUAL)).toEqual({});
  for (const text of [
    '',
    '{}',
    '3',
    '{"align":"place","exact":1,"tolerance":3,"start":"0","variants":{"M":1,"m":"B"}}',
  ]) {
    expect(howOf(text)).toEqual(USUAL);
  }
});

it('command and request say exactly the same', () => {
  expect(commandOf(HOW, 'r-a', 'r-b')).toBe(
    'motionlab compare r-a r-b --align reference --samples intersection --from=0.5 --to=10 --tolerance 1e-9,0.01 ' +
      "--time-tolerance 0.002 --tolerance '*.x.it'\\''s=0.000001,0,0' " +
      "--interpolation '*.x.it'\\''s=hold' --only 'B.*' --variant M=B",
  );
  expect(commandOf({ ...USUAL, offset: -1e-7 }, 'r-a', 'r-b')).toBe(
    'motionlab compare r-a r-b --offset=-1e-7',
  );
  expect(commandOf({ ...USUAL, exact: true }, 'r-a', 'r-b')).toBe(
    'motionlab compare r-a r-b --exact',
  );
  expect(curlOf(USUAL, 'r-a', 'r-b', 'http://h')).toBe(
    'curl -s -H \'Content-Type: application/json\' -d \'{"a":"r-a","b":"r-b"}\' http://h/api/v1/runs/compare',
  );
});

it('exchanged runs are compared alike', () => {
  const how = { ...USUAL, offset: 0.25, start: 1, variants: { M: 'B' } };
  const other = { ...USUAL, offset: -0.25, start: 0.75, variants: { B: 'M' } };
  expect(swapped(how)).toEqual(other);
  expect(swapped(other)).toEqual(how);
  expect(swapped(USUAL)).toEqual(USUAL);
  expect(swapped({ ...USUAL, align: 'index', start: 1, end: 2 })).toEqual({
    ...USUAL,
    align: 'index',
  });
});

it('a variant of 2 is compared with one of 1, and what was there moves away', () => {
  const [one, two] = [
    ['A', 'B'],
    ['A', 'B'],
  ];
  expect(shareNone(['A', 'B'], ['M'])).toBe(true);
  expect(shareNone(one, two)).toBe(false);
  expect(shareNone(one, [])).toBe(false);
  expect(withVariant({}, 'M', 'B', one, ['M'])).toEqual({ M: 'B' });
  expect(withVariant({}, 'A', 'B', one, two)).toEqual({ A: 'B', B: 'A' });
  expect(withVariant({ A: 'B', B: 'A' }, 'A', 'A', one, two)).toEqual({});
  expect(withVariant({}, 'M', 'A', one, ['A', 'M'])).toEqual({ M: 'A', A: 'B' });
  expect(withVariant({}, 'M', 'A', ['A'], ['A', 'M'])).toBeNull();
});

it('patterns go from the channel to all', () => {
  const values = (channel: string) => patternsOf(channel).map(({ value }) => value);
  expect(values('B.x.thrust')).toEqual(['B.x.thrust', '*.x.thrust', '*.thrust', '*']);
  expect(values('x.load_force')).toEqual(['x.load_force', '*.load_force', '*']);
  expect(values('Temp')).toEqual(['Temp', '*']);
});

const CHANNEL: ChannelComparison = {
  name: 'B.x.thrust',
  unit: 'N',
  candidate_unit: 'N',
  verdict: 'within',
  interpolation: 'linear',
  tolerance: { absolute: 0, relative: 0, time: 0 },
  largest: -0.5,
  at: { time: 1.5, candidate_time: 1.5, lap: null, arc: null },
  beyond: 0,
  rms: 0.1,
  range: 20,
  compared: 10,
  single: 0,
};
const channel = (rest: Partial<ChannelComparison>): ChannelComparison => ({ ...CHANNEL, ...rest });
const none = { largest: null, at: null, beyond: null, rms: null };
it('the verdict is a sentence', () => {
  const comparison = { headline: 'agrees within 1.4 % RMS on 6 of 6', holds: true } as Comparison;
  const text = 'Agrees within 1.4 % RMS on 6 of 6.';
  expect(headlineOf(comparison)).toEqual({ text, holds: true });
});

it('B is drawn, or what both have', () => {
  const of = (...letters: string[]) => ({
    columns: letters.map((letter) => ({ name: `${letter}.x.thrust` })),
  });
  expect(comparedVariant([of('A', 'B'), of('A', 'B')], {})).toEqual(['B', 'B']);
  expect(comparedVariant([of('A', 'B'), of('M')], { M: 'B' })).toEqual(['B', 'M']);
  expect(comparedVariant([of('A'), of('B')], {})).toBeNull();
});

it('what was not compared never looks like a pass', () => {
  const missing = channel({ name: 'a', verdict: 'missing', candidate_unit: null, ...none });
  const out = channel({ name: 'b', verdict: 'out-of-tolerance', beyond: 0.0001 });
  expect(countsOf([CHANNEL, missing, out]).map(([verdict]) => verdict)).toEqual([
    'out-of-tolerance',
    'missing',
    'within',
  ]);
  expect(reasonText(missing)).toBe('only in 1');
  expect(reasonText(channel({ verdict: 'units-differ', candidate_unit: '1' }))).toBe(
    'N and no unit',
  );
});

it('channels are sorted by size, the largest first, and a third click takes that back', () => {
  const small = channel({ name: 'small', largest: 0.1 });
  const empty = channel({ name: 'empty', verdict: 'empty', ...none });
  const all = [small, empty, CHANNEL];
  const once = sortedBy({ by: null, down: false }, 'largest');
  expect(listed(all, '', once).map(({ name }) => name)).toEqual(['B.x.thrust', 'small', 'empty']);
  const twice = sortedBy(once, 'largest');
  expect(listed(all, '', twice)[0]?.name).toBe('empty');
  expect(sortedBy(twice, 'largest')).toEqual({ by: null, down: false });
  expect(listed(all, 'empty', once)).toEqual([empty]);
});

it('figures are short, and exact in the file', () => {
  const tolerance = { absolute: 2e-6, relative: 0.015, time: 0.002 };
  const micro = { factor: 1e6, unit: 'µm' };
  expect(toleranceText(channel({ tolerance }), micro)).toBe('±2, 1.5 %, 2 ms');
  expect(toleranceText(CHANNEL, micro)).toBe('0');
  expect([beyondText(0), beyondText(0.0001), beyondText(0.0184)]).toEqual([
    '0 %',
    '<0.1 %',
    '1.8 %',
  ]);
  const place = { time: 1.5, candidate_time: 1.5 };
  expect(placeText({ ...place, lap: null, arc: null })).toBe('1.5000 s');
  expect(placeText({ ...place, lap: 1, arc: 0.0125 })).toBe('lap 2, 12.50 mm');
  expect(csvOf({ channels: [channel({ name: 'a "b", c' })] } as Comparison).split('\n')[1]).toBe(
    '"a ""b"", c",N,within,0,0,0,linear,-0.5,1.5,1.5,,,0,0.1,10,0',
  );
  expect(
    csvOf({ channels: [channel({ name: '=1+1', unit: '@V' })] } as Comparison).split('\n')[1],
  ).toMatch(/^'=1\+1,'@V,within,/);
});

it('a list tells what differs from the baseline, where it can be told', () => {
  const run = (scenario: string, ...differences: [string, unknown, unknown][]) =>
    ({
      scenario,
      differences: differences.map(([path, shipped, value]) => ({ path, shipped, value })),
    }) as Run;
  const base = run('circle', ['a', 1, 2], ['b', 1, 5]);
  expect(differsFrom(base, run('circle', ['a', 1, 3], ['c', 7, 8]))).toEqual([
    { path: 'a', shipped: 2, value: 3 },
    { path: 'c', shipped: 7, value: 8 },
    { path: 'b', shipped: 5, value: 1 },
  ]);
  expect(differsFrom(base, base)).toEqual([]);
  expect(differsFrom(base, run('stair'))).toBeNull();
});

it('what was set differently is said with what cannot be known', () => {
  const detail = (rest: object) =>
    ({ kind: 'simulation', events: [], version: '1', model: 'm', ...rest }) as unknown as RunDetail;
  const one = detail({ scenario_document: { seed: 1 } });
  const two = detail({ scenario_document: { seed: 2 }, version: '2', events: [{ kind: 'push' }] });
  const differences = setDifferently(one, two);
  expect(differences.fields).toHaveLength(1);
  expect(differences.notes).toEqual(['while 2 ran: pushes: 1', 'version 1 → 2']);
  const measured = detail({ kind: 'measurement', scenario_document: null });
  expect(setDifferently(one, measured).notes).toEqual(['2 is measured, without a scenario']);
});

it('places of the axis are instants, and excursions are found', () => {
  const numbers = Float32Array.from([0, 1, 2, 3, 0, 1, 1, 0, 0, 1, 1, 0]);
  const window = new ComparisonWindow(
    { start: 100, step: 10, count: 4, total: 500 },
    { name: 'time', unit: 's', start: 5, lap_length: null, values: 0 },
    numbers,
    [{ name: 'beyond', unit: '1', minimum: 4, maximum: 8 }],
  );
  expect([...window.x]).toEqual([5, 6, 7, 8]);
  expect(window.instantsOf({ from: 6.2, to: 7.1 })).toEqual({ from: 110, to: 130 });
  expect(window.instantsOf({ from: 0, to: 99 })).toEqual({ from: 100, to: 140 });
  expect(window.excursions()).toEqual([{ from: 1, to: 3 }]);
  expect(window.extent('baseline')).toBeNull();
});

it('a run without channels of a variant says so', () => {
  const columns = (...names: string[]) => ({ columns: names.map((name) => ({ name })) });
  expect(lettersOf(columns('B.x.thrust', 'A.x.thrust', 'A.y.thrust', 'M.Temp'))).toEqual([
    'A',
    'B',
  ]);
  expect(lettersOf(columns('x.position_reference', 'Temp'))).toEqual([]);
  expect(withoutVariants(['A'], ['M'])).toBe('');
  expect(withoutVariants(['A'], [])).toContain('2 has no channels of a variant');
  expect(withoutVariants([], [])).toContain('1 and 2 have no channels');
});

it('a comparison can end before the first STOP', () => {
  const going = { period: 0.0005, events: [] };
  const stop = { tick: 4001, kind: 'stop' } as unknown as RunDetail['events'][number];
  const stopped = { period: 0.0005, events: [stop] };
  expect(lastBeforeStop(USUAL, [going, going])).toBeNull();
  expect(lastBeforeStop(USUAL, [going, stopped])).toBe(2);
  expect(lastBeforeStop({ ...USUAL, offset: 0.5 }, [going, stopped])).toBe(2.5);
  expect(lastBeforeStop({ ...USUAL, offset: 0.5 }, [stopped, stopped])).toBe(2);
  expect(lastBeforeStop({ ...USUAL, end: 2 }, [going, stopped])).toBeNull();
  expect(lastBeforeStop({ ...USUAL, start: 3 }, [going, stopped])).toBeNull();
  expect(lastBeforeStop({ ...USUAL, align: 'index' }, [going, stopped])).toBeNull();
});
