import { expect, it } from 'vitest';
import type { Scenario } from '../api/types';
import { snapshot, toChange } from './gains';

const controller = {
  x: { k_p: 1, k_d: 2 },
  y: { k_p: 3, k_d: 4 },
  compensation: { law: 'off', enabled: true },
  feedforward: false,
  disturbance_observer: { enabled: false },
};
const scenario = {
  variants: { A: { label: '', controller } },
} as unknown as Scenario;

it('keeps gains, law and switches', () => {
  expect(snapshot(scenario)).toEqual({
    'variants.A.controller.x.k_p': 1,
    'variants.A.controller.x.k_d': 2,
    'variants.A.controller.y.k_p': 3,
    'variants.A.controller.y.k_d': 4,
    'variants.A.controller.compensation.law': 'off',
    'variants.A.controller.compensation.enabled': true,
    'variants.A.controller.feedforward': false,
    'variants.A.controller.disturbance_observer.enabled': false,
  });
});

it('changes only what differs and is there', () => {
  const set = {
    ...snapshot(scenario),
    'variants.A.controller.x.k_p': 9,
    'variants.B.controller.x.k_p': 9,
  };
  expect(toChange(scenario, set)).toEqual({ 'variants.A.controller.x.k_p': 9 });
});
