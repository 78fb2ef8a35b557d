import { expect, it } from 'vitest';
import type { Scenario } from '../api/types';
import { lawName, served } from './fields.svelte';

const LAWS = {
  off: 'no compensation',
  'published-k': 'K as published',
  'lugre-observer': 'LuGre observer, K = 0',
};
served.scenario = {
  ...served.scenario,
  fields: {
    'variants.*.controller.compensation.law': {
      label: 'law',
      unit: '',
      factor: 1,
      whole: false,
      description: '',
      choices: Object.entries(LAWS).map(([value, label]) => ({
        value,
        label,
        description: '',
        unit: '',
      })),
    },
  },
};

const scenario = (law: string, enabled = true) =>
  ({
    variants: { B: { label: 'LuGre observer', controller: { compensation: { law, enabled } } } },
  }) as unknown as Scenario;

it('names the law that runs, whatever the scenario called it', () => {
  expect(lawName(scenario('published-k'), 'B')).toBe('K as published');
  expect(lawName(scenario('lugre-observer'), 'B')).toBe('LuGre observer, K = 0');
  expect(lawName(scenario('lugre-observer', false), 'B')).toMatch(/, switched off$/);
  expect(lawName(scenario('off', false), 'B')).toBe('no compensation');
  expect(lawName(scenario('off'), 'C')).toBe('');
  expect(lawName(null, 'B')).toBe('');
});
