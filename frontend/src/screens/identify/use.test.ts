import { describe, expect, it } from 'vitest';
import type { Scenario } from '../../app/api/types';
import { comparison, compensates, forVariants, present } from './use';

const controller = (law: string) => ({
  compensation: { law, enabled: false },
  model: { x: { friction: { F_s: 3.6 } } },
});
const scenario = {
  name: 'circle',
  schedule: [{ time: 90, set: {} }],
  variants: {
    A: { label: 'off', controller: controller('off') },
    B: { label: 'observer', controller: controller('observer') },
  },
} as unknown as Scenario;
const found = { 'variants.B.controller.model.x.friction.F_s': 3.1 };

it('gives the changes of one variant to others', () => {
  expect(forVariants({ ...found, seed: 3 }, 'B', ['A', 'C'])).toEqual({
    'variants.A.controller.model.x.friction.F_s': 3.1,
    'variants.C.controller.model.x.friction.F_s': 3.1,
  });
});

describe('the comparison', () => {
  const set = {
    plant: 'matched',
    'variants.A.controller.x.k_p': 1,
    'variants.B.controller.x.k_p': 2,
  };
  const made = comparison(scenario, set, 'B', found);

  it('runs the same controller twice, without the schedule', () => {
    expect(Object.keys(made.scenario.variants)).toEqual(['A', 'B']);
    expect(made.scenario.variants.A?.controller).toBe(scenario.variants.B?.controller);
    expect(made.scenario.variants.B?.controller).toBe(scenario.variants.B?.controller);
    expect(made.scenario.schedule).toEqual([]);
  });

  it('changes only the model of B, and what came with the experiment in both', () => {
    expect(made.set).toEqual({
      plant: 'matched',
      'variants.A.controller.x.k_p': 2,
      'variants.B.controller.x.k_p': 2,
      'variants.A.controller.compensation.enabled': true,
      'variants.B.controller.compensation.enabled': true,
      'variants.B.controller.model.x.friction.F_s': 3.1,
    });
  });

  it('cannot differ without a compensation', () => {
    expect(compensates(scenario, {}, 'A')).toBe(false);
    expect(compensates(scenario, {}, 'B')).toBe(true);
    const law = 'variants.B.controller.compensation.law';
    expect(compensates(scenario, { [law]: 'off' }, 'B')).toBe(false);
    expect(comparison(scenario, {}, 'A', {}).set).toEqual({});
  });
});

it('reads what changes would replace', () => {
  expect(present(scenario, { ...found, 'variants.Z.label': 'x' })).toEqual({
    'variants.B.controller.model.x.friction.F_s': 3.6,
  });
});
