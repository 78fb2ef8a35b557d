import { beforeEach, describe, expect, it } from 'vitest';
import type { Lanes } from '../../kernel/lanes';
import { exampleLanes } from '../../kernel/example-lanes';
import type { Changes, Scenario } from '../api/types';
import { withChanges } from '../api/scenario-paths';
import { Beyond, changedLanes, type LaneCode, Refused } from './changed-lanes';

const friction = { enabled: true, sigma_0: 100, sigma_1: 10, F_c: 1, F_s: 2 };
const encoder = { noise: 0 };
const axis = { mass: 5, stop_damping: 0, stop_stiffness: 0, friction, encoder };
const controller = {
  x: { k_p: 1 },
  y: { k_p: 1 },
  compensation: { law: 'off', enabled: true },
  model: { x: { friction }, y: { friction } },
};
const shipped = {
  name: 'example',
  plant: { name: 'nominal', x: axis, y: axis },
  variants: { A: { controller }, B: { controller } },
  trajectory: { kind: 'circle', radius: 0.1 },
  schedule: [{ time: 3, set: { 'variants.A.controller.x.k_p': 7 } }],
  settling_band: 1,
} as unknown as Scenario;

/** Two rows: k_p, and one that a table decides. */
const code: LaneCode = {
  STATES: ['plant.p'],
  PARAMETERS: ['force_model.sharing.law', 'k_p'],
  LEAST_NORM: 0,
  PLANT_STEP: 0.1,
  rows: ({ variants }, name, of) => {
    const own = variants[name]?.controller as unknown as Record<string, { k_p: number }>;
    return [undefined, own[of]?.k_p];
  },
  refusal: ({ law }: { law?: string }) =>
    law === 'residual-k'
      ? { parameter: 'gain', value: 9, reason: 'it feeds itself', limit: 8 }
      : null,
};

let lanes: Lanes;
beforeEach(() => {
  // Of every epoch, variant and row: x and y.
  lanes = { ...exampleLanes(), lanes: new Float64Array(16) };
});
const changed = (set: Changes) => changedLanes(code, lanes, shipped, withChanges(shipped, set));

describe('lanes of a changed scenario', () => {
  it('has what the schedule changes from its time on, and rows of tables as they were', () => {
    lanes.lanes[0] = 0;
    const { lanes: numbers } = changed({ 'variants.A.controller.x.k_p': 3 });
    expect([...numbers]).toEqual([0, 0, 3, 1, 0, 0, 1, 1, 0, 0, 7, 1, 0, 0, 1, 1]);
  });

  it('says which law it has, and leaves notes out that may no longer hold', () => {
    const compensation = { 'variants.B.controller.compensation.law': 'lugre' };
    const [window] = changed({ ...compensation, settling_band: 2 }).windows;
    expect(window?.settling_band).toBe(2);
    expect(window?.variants['B']).toMatchObject({ law: 'lugre', notes: [] });
    expect(window?.variants['A']).toMatchObject({ law: 'off', notes: ['as planned'] });
  });

  it('takes no change of the inputs', () => {
    for (const set of [{ 'trajectory.radius': 0.2 }, { 'plant.x.encoder.noise': 1 }]) {
      expect(() => changed(set as Changes), JSON.stringify(set)).toThrow(Beyond);
    }
  });

  it('refuses what a server refuses, with the field', () => {
    const refused = [
      [{ 'plant.x.friction.F_s': 0.5 }, 'plant.x.friction.F_s'],
      [{ 'plant.y.mass': 0.9 }, 'plant.y.mass'],
      [
        { 'variants.A.controller.compensation.law': 'residual-k' },
        'variants.A.controller.compensation.gain',
      ],
    ] as const;
    for (const [set, loc] of refused) {
      try {
        changed(set as Changes);
        expect.unreachable(loc);
      } catch (error) {
        expect(error).toBeInstanceOf(Refused);
        expect((error as Refused).fields[0]?.loc).toBe(loc);
      }
    }
  });
});
