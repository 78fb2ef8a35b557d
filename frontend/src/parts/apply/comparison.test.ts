import { describe, expect, it } from 'vitest';
import type { Scenario } from '../../app/api/types';
import { forVariants, present, twice } from './comparison.svelte';

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
const identified = { 'variants.B.controller.model.x.friction.F_s': 3.1 };

it('gives the changes of one variant to others', () => {
  expect(forVariants({ ...identified, seed: 3 }, 'B', ['A', 'C'])).toEqual({
    'variants.A.controller.model.x.friction.F_s': 3.1,
    'variants.C.controller.model.x.friction.F_s': 3.1,
  });
});

describe('the comparison', () => {
  const set = {
    plant: 'matched',
    'variants.A.controller.x.k_p': 1,
    'variants.B.controller.x.k_p': 2,
    'variants.B.controller.y.k_p': 3,
  };
  const made = twice({
    scenario,
    set,
    variant: 'B',
    chosen: { ...identified, 'variants.B.controller.y.k_p': 4 },
    labels: ['old', 'new'],
  });

  it('runs the same controller twice, without the schedule', () => {
    expect(Object.keys(made.scenario.variants)).toEqual(['A', 'B']);
    expect(made.scenario.variants.A?.controller).toBe(scenario.variants.B?.controller);
    expect(made.scenario.variants.B?.controller).toBe(scenario.variants.B?.controller);
    expect(made.scenario.schedule).toEqual([]);
  });

  it('changes only B, and what came with the experiment in both', () => {
    expect(made.set).toEqual({
      plant: 'matched',
      'variants.A.controller.x.k_p': 2,
      'variants.A.controller.y.k_p': 3,
      'variants.B.controller.x.k_p': 2,
      'variants.B.controller.y.k_p': 4,
      'variants.B.controller.model.x.friction.F_s': 3.1,
    });
  });
});

it('reads what changes would replace', () => {
  expect(present(scenario, { ...identified, 'variants.Z.label': 'x' })).toEqual({
    'variants.B.controller.model.x.friction.F_s': 3.6,
  });
});
