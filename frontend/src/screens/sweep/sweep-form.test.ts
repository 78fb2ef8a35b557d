import { describe, expect, it } from 'vitest';
import type { Scenario } from '../../app/api/types';
import {
  casesOf,
  gridOf,
  isWrong,
  groupsOf,
  refusedFields,
  sweptFields,
  sweptOf,
  type Refused,
} from './sweep-form';

const GAIN = 'variants.B.controller.x.k_p';
const scenario = {
  title: 'a',
  seed: 7,
  learnt: { laps: 12, x: 'AAAA' },
  plant: { name: 'nominal', x: { mass: 6 } },
  variants: {
    B: {
      controller: { x: { k_p: 2e5 }, compensation: { enabled: true }, model: { x: { mass: 6 } } },
    },
  },
} as unknown as Scenario;

it('lists numbers and switches by what they belong to, and no names', () => {
  const groups = Object.fromEntries(
    groupsOf(scenario).map(({ name, fields }) => [name, fields.map(({ path }) => path)]),
  );
  expect(groups.motor).toEqual(['plant']);
  expect(groups['controller B']).toEqual([GAIN, 'variants.B.controller.compensation.enabled']);
  expect(groups['model of B']).toEqual(['variants.B.controller.model.x.mass']);
  expect(groups['plant x']).toEqual(['plant.x.mass']);
  expect(groups.scenario).toEqual(['seed']);
  expect(groups.learnt).toBeUndefined();
});

describe('a swept field', () => {
  it('spans half to double its value, in the unit of the screen, and is asked for in SI', () => {
    const swept = sweptOf(GAIN, scenario, []);
    expect(swept).toMatchObject({ by: 'range', start: '100', stop: '400', scale: 'log' });
    expect(gridOf([swept])).toEqual([
      { path: GAIN, start: 1e5, stop: 4e5, count: 9, scale: 'log' },
    ]);
  });

  it('takes names, switches and numbers one by one', () => {
    const fields = [
      { ...sweptOf('plant', scenario, ['nominal', 'matched']) },
      { ...sweptOf('variants.B.controller.compensation.enabled', scenario, []) },
      { ...sweptOf(GAIN, scenario, []), by: 'values' as const, values: '150, 200 250;300' },
    ];
    expect(gridOf(fields).map((each) => (each as { values: unknown }).values)).toEqual([
      ['nominal', 'matched'],
      [false, true],
      [150e3, 200e3, 250e3, 300e3],
    ]);
    expect(casesOf('grid', fields)).toBe(16);
  });

  it('is refused beside its input where it holds no number', () => {
    const wrong = { ...sweptOf(GAIN, scenario, []), stop: '4oo' };
    try {
      gridOf([sweptOf('plant.x.mass', scenario, []), wrong]);
      expect.unreachable();
    } catch (error) {
      expect((error as Refused).problems).toEqual({
        1: [{ key: 'stop', text: '“4oo” is not a number.' }],
      });
    }
  });
});

it('swept fields come back from a request', () => {
  const fields = [sweptOf(GAIN, scenario, []), sweptOf('plant', scenario, ['nominal', 'matched'])];
  expect(gridOf(sweptFields({ grid: gridOf(fields) }))).toEqual(gridOf(fields));
});

it('refusals go to their field', () => {
  const bounds = { minimum: 0, maximum: 1e9 };
  const { byField, others } = refusedFields([
    { loc: 'grid.1.stop', message: `${GAIN}: is out of range`, value: -5, bounds, unit: 'N/m' },
    { loc: 'grid.0', message: 'takes values, or start, stop and count, not both' },
    { loc: 'sweep', message: '20000 cases are more than 10000' },
  ]);
  expect(byField[1]?.[0]?.text).toContain('Is out of range');
  expect(byField[1]?.[0]?.key).toBe('stop');
  expect(byField[0]?.[0]?.text).toBe('Takes values, or start, stop and count, not both.');
  expect(byField[1]?.[0]?.text).toContain('1000000 N/mm');
  expect(others).toEqual(['20000 cases are more than 10000.']);
});

it('marks the input that holds what is refused, or all where it is not known', () => {
  const swept = { ...sweptOf(GAIN, scenario, []), start: '-5', stop: '400' };
  const marked = (problem: object) =>
    (['start', 'stop', 'count'] as const).filter((key) =>
      isWrong(swept, [{ text: '', ...problem }], key),
    );
  expect(marked({ key: 'count' })).toEqual(['count']);
  expect(marked({ value: -5000 })).toEqual(['start']);
  expect(marked({ value: 7 })).toEqual(['start', 'stop', 'count']);
  expect(marked({})).toEqual(['start']);
  swept.start = '5';
  expect(marked({})).toEqual(['start', 'stop', 'count']);
});

it('names the controller of each of its fields', () => {
  const names = groupsOf(scenario).flatMap(({ fields }) => fields.map(({ name }) => name));
  expect(names.filter((name) => name.startsWith('B '))).toHaveLength(3);
});
