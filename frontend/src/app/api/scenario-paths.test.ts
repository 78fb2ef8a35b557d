import { describe, expect, it } from 'vitest';
import {
  at,
  atStart,
  difference,
  fitting,
  numberAt,
  withChanges,
  withValue,
} from './scenario-paths';
import type { Scenario } from './types';

const scenario = {
  name: 'circle',
  title: 'A circle',
  description: '',
  seed: 2019,
  plant: { name: 'nominal', description: '', x: { mass: 5.9, gain: [1, 1, 1] } },
  variants: {
    A: { label: 'none', controller: { name: 'pd', x: { k_p: 200300, k_d: 1530 } } },
    B: { label: 'LuGre', controller: { name: 'lugre-observer', x: { k_p: 200300, k_d: 1530 } } },
  },
  trajectory: { kind: 'circle', radius: 0.015 },
} as unknown as Scenario;
const matched = { name: 'matched', description: 'a fit', x: { mass: 5.9, gain: [1, 1, 0.9] } };

describe('changes of a link', () => {
  const now = {
    schedule: [],
    plant: { name: 'nominal', x: { mass: 5.9 } },
    variants: { A: { controller: { x: { k_p: 1, notch: { frequency: 100 } } } } },
    trajectory: { kind: 'circle', radius: 0.015 },
    learnt: { laps: 3 },
  } as unknown as Scenario;

  it('are taken where they have the form of what they replace', () => {
    const good = {
      'variants.A.controller.x.k_p': 2,
      'variants.A.controller.x.notch': null,
      trajectory: { kind: 'line', end: { x: 0.001 } },
      'plant.x.load': { any: 1 },
      learnt: null,
    };
    expect(fitting(good, now)).toEqual(good);
  });

  it('are left out where they have another', () => {
    const bad = {
      schedule: 5,
      variants: null,
      'variants.A': null,
      plant: { x: 1 },
      'plant.x.mass': 'heavy',
      trajectory: [1],
      ...(JSON.parse('{"__proto__":1}') as object),
    };
    expect(fitting(bad, now)).toEqual({});
  });
});

describe('paths', () => {
  it('reads', () => {
    expect(numberAt(scenario, 'variants.B.controller.x.k_p')).toBe(200300);
    expect(numberAt(scenario, 'variants.B.controller.x')).toBeNaN();
    expect(at(scenario, 'plant.z.mass')).toBeUndefined();
  });
  it('writes a copy', () => {
    const other = withValue(scenario, 'trajectory.radius', 0.02);
    expect(numberAt(other, 'trajectory.radius')).toBe(0.02);
    expect(numberAt(scenario, 'trajectory.radius')).toBe(0.015);
    expect(other.plant).toBe(scenario.plant);
  });
  it('applies a part before what lies inside it', () => {
    const parts = { 'plant=matched': matched };
    const other = withChanges(scenario, { 'plant.x.mass': 7, plant: 'matched' }, parts);
    expect(other.plant).toEqual({ ...matched, x: { ...matched.x, mass: 7 } });
  });
});

describe('difference', () => {
  it('is empty between equals', () => {
    expect(difference(scenario, structuredClone(scenario))).toEqual([]);
  });
  it('lists values, not words', () => {
    const other = withChanges(scenario, {
      'variants.B.controller.x.k_p': 312000,
      'variants.B.label': 'stiffer',
      seed: 1,
    });
    expect(difference(scenario, other)).toEqual([
      { path: 'seed', from: 2019, to: 1 },
      { path: 'variants.B.controller.x.k_p', from: 200300, to: 312000 },
    ]);
  });
  it('names another motor once', () => {
    const other = { ...scenario, plant: matched };
    expect(difference(scenario, other)).toEqual([
      { path: 'plant', from: 'nominal', to: 'matched' },
    ]);
  });
  it('compares what was learnt as one value', () => {
    const [from, to] = [
      { laps: 3, x: 'AAAA' },
      { laps: 5, x: 'AACA' },
    ];
    expect(difference({ learnt: from }, { learnt: to })).toEqual([{ path: 'learnt', from, to }]);
  });
  it('compares lists as one value', () => {
    const other = withValue(scenario, 'plant.x.gain', [1, 1, 0.9]);
    expect(difference(scenario, other)).toEqual([
      { path: 'plant.x.gain', from: [1, 1, 1], to: [1, 1, 0.9] },
    ]);
  });
  it('sees what one side lacks', () => {
    const other = { ...scenario, trajectory: { kind: 'circle', radius: 0.015, laps: 3 } };
    expect(difference(scenario, other)).toEqual([
      { path: 'trajectory.laps', from: undefined, to: 3 },
    ]);
  });
});

it('has a scenario as it holds at 0 s, with what a person has changed', () => {
  const later = { 'variants.B.controller.x.k_p': 5, 'variants.B.controller.x.k_d': 6 };
  const base = { ...scenario, schedule: [{ time: 90, set: later }] } as unknown as Scenario;
  const restored = { 'plant.x.mass': 7, 'variants.B.controller.x.k_d': 8 };
  const now = withChanges(withChanges(base, later), restored);
  const changes = [{ tick: 9, set: restored, previous: {} }];
  expect(atStart({ base, scenario: now, changes })).toEqual(withChanges(base, restored));
  expect(atStart({ base, scenario: base, changes: [] })).toEqual(base);
});
