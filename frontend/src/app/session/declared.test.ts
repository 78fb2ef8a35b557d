import { expect, it } from 'vitest';
import type { Scenario } from '../api/types';
import { declaredAs } from './declared';

const scenario = (compensation: object) =>
  ({
    seed: 1,
    variants: { B: { controller: { feedforward: true, compensation } } },
  }) as unknown as Scenario;

const kept = scenario({ law: 'mine', share: 0.5, gone: 3 });
const now = scenario({ law: 'off', share: 1, limit: 4 });

it('keeps values, and takes new parameters and not those that went', () => {
  expect(declaredAs(kept, now)).toEqual(scenario({ law: 'mine', share: 0.5, limit: 4 }));
});
