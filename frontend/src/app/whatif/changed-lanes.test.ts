import { beforeEach, describe, expect, it } from 'vitest';
import type { Lanes } from '../../kernel/lanes';
import { exampleLanes } from '../../kernel/example-lanes';
import type { Changes, FieldEntry, Scenario } from '../api/types';
import { withChanges } from '../api/scenario-paths';
import { served } from '../fields/fields.svelte';
import { Beyond, changedLanes, type LaneCode } from './changed-lanes';
import { Refused } from './refused-changes';

const friction = { enabled: true, sigma_0: 100, sigma_1: 10, F_c: 1, F_s: 2 };
const encoder = { noise: 0, jitter: 0, resolution: 1 };
const force_map = { kind: 'analytic', tau: 1 };
const axis = {
  mass: 5,
  stop_damping: 0,
  stop_stiffness: 0,
  friction,
  encoder,
  force_map,
  effects: [],
};
const controller = {
  x: { k_p: 1 },
  y: { k_p: 1 },
  compensation: { law: 'off', enabled: true },
  sharing: { law: 'least-norm', overlap: 0.1 },
  model: { x: { friction, force_map }, y: { friction, force_map } },
};
const shipped = {
  name: 'example',
  plant: { name: 'nominal', x: axis, y: axis },
  variants: { A: { controller }, B: { controller } },
  trajectory: { kind: 'circle', radius: 0.1 },
  learnt: null,
  schedule: [{ time: 3, set: { 'variants.A.controller.x.k_p': 7 } }],
  settling_band: 1,
} as unknown as Scenario;

/** Two rows: k_p, and one that a table decides. */
const code: LaneCode = {
  MODEL: 'abc',
  LAWS: { off: {}, lugre: {}, 'residual-k': {} },
  STATES: ['plant.p'],
  PARAMETERS: ['force_model.sharing.law', 'k_p'],
  CLOSED_FORM: 0,
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

const law = {
  choices: ['off', 'lugre', 'residual-k', 'mine'].map((value) => ({ value })),
};
const gain = { unit: '1/s', bounds: { minimum: 0 } };
const fields = {
  'variants.*.controller.compensation.law': law,
  'variants.*.controller.compensation.gain': gain,
  'plant.x.mass': { bounds: { minimum: 0.1, maximum: 10 }, unit: 'kg' },
} as unknown as Record<string, FieldEntry>;
served.scenario = { ...served.scenario, fields: { ...served.scenario.fields, ...fields } };

let lanes: Lanes;
beforeEach(() => {
  // Of every epoch, variant and row: x and y; A's k_p x is scheduled.
  const numbers = [5, 5, 1, 1, 5, 5, 1, 1, 5, 5, 7, 1, 5, 5, 1, 1];
  lanes = { ...exampleLanes(), lanes: Float64Array.from(numbers) };
});
const changed = (set: Changes, before = shipped, its = code) =>
  changedLanes(its, lanes, before, withChanges(before, set));

describe('lanes of a changed scenario', () => {
  it('has what the schedule changes from its time on, and rows of tables as they were', () => {
    const { lanes: numbers } = changed({ 'variants.A.controller.x.k_p': 3 });
    expect([...numbers]).toEqual([5, 5, 3, 1, 5, 5, 1, 1, 5, 5, 7, 1, 5, 5, 1, 1]);
  });

  it('keeps the last bit of numbers that stay', () => {
    const [place, bit] = [6, 1 + 2 ** -52];
    lanes.lanes[place] = bit;
    const { lanes: numbers } = changed({ 'variants.A.controller.x.k_p': 3 });
    expect([numbers[2], numbers[place]]).toEqual([3, bit]);
  });

  it('says which law it has, and leaves notes out that may no longer hold', () => {
    const compensation = { 'variants.B.controller.compensation.law': 'lugre' };
    const [window] = changed({ ...compensation, settling_band: 2 }).windows;
    expect(window?.settling_band).toBe(2);
    expect(window?.variants['B']).toMatchObject({ law: 'lugre', notes: [] });
    expect(window?.variants['A']).toMatchObject({ law: 'off', notes: ['as planned'] });
    const [other] = changed({ 'plant.x.encoder.resolution': 2 }).windows;
    expect(other?.variants['A']?.notes).toEqual([]);
  });

  it.each([
    { 'trajectory.radius': 0.2 },
    { 'plant.x.encoder.noise': 1 },
    { 'plant.x.encoder.jitter': 1e-6 },
    { 'plant.y.effects': [{ effect: 'gms' }] },
    { 'plant.x.unheard': 1 },
    { learnt: { laps: 3 } },
    { 'plant.x.mass': 'heavy' },
    { 'variants.A.controller.compensation.law': 'unheard' },
    { 'variants.B.controller.compensation.law': 'mine' },
  ])('are the server’s where the page lacks something: %o', (set) => {
    expect(() => changed(set as Changes)).toThrow(Beyond);
  });

  it('are the server’s where a table decides them', () => {
    const tabled = { kind: 'table', name: 'own', gain: 1 };
    const path = 'variants.A.controller.model.y.force_map';
    const before = withChanges(shipped, { [path]: tabled });
    for (const set of [{ 'variants.A.controller.sharing.overlap': 0.2 }, { [`${path}.gain`]: 2 }]) {
      expect(() => changed(set, before), JSON.stringify(set)).toThrow(Beyond);
    }
    expect(() => changed({ 'variants.B.controller.sharing.overlap': 0.2 }, before)).not.toThrow();
  });

  it('are the server’s where the motion is planned for the motor', () => {
    const path = { kind: 'path', law: 'time_optimal', planned_for: null };
    const before = withChanges(shipped, { trajectory: path });
    expect(() => changed({ 'plant.x.mass': 6 }, before)).toThrow(Beyond);
    const planned = withChanges(before, { 'trajectory.planned_for': {} });
    expect(() => changed({ 'plant.x.mass': 6 }, planned)).not.toThrow();
  });

  it('are the server’s where it makes others, or has another model', () => {
    const set = { 'variants.A.controller.x.k_p': 3 };
    expect(() => changed(set, shipped, { ...code, MODEL: 'other' })).toThrow('another version');
    lanes.lanes[6] = 1.001;
    expect(() => changed(set)).toThrow('another k_p');
    lanes = exampleLanes();
    const PARAMETERS = ['k_p'];
    expect(() => changed(set, shipped, { ...code, PARAMETERS })).toThrow('other rows');
  });

  it('refuses what a server refuses, in its words', () => {
    const law = 'variants.A.controller.compensation.law';
    const refused = [
      [
        { 'plant.x.friction.F_s': 0.5 },
        { loc: 'plant.x.friction', message: 'F_s = 0.5 N is below F_c = 1 N' },
      ],
      [
        { 'plant.y.mass': 0.9 },
        {
          loc: 'plant.y',
          message:
            'mass = 0.9 kg is too small for friction.sigma_0: steps of 100000 us need >= 1 kg',
        },
      ],
      [
        { 'plant.x.mass': 0.01, 'plant.x.friction.F_s': 5 },
        {
          loc: 'plant.x.mass',
          message: 'is out of range',
          value: 0.01,
          bounds: { minimum: 0.1, maximum: 10 },
          unit: 'kg',
        },
      ],
      [
        { [law]: 'residual-k' },
        {
          loc: 'variants.A.controller.compensation.gain',
          message: 'is unstable on x: it feeds itself',
          value: 9,
          bounds: { minimum: 0, exclusive_maximum: 8 },
          unit: '1/s',
        },
      ],
    ] as const;
    for (const [set, problem] of refused) {
      try {
        changed(set as Changes);
        expect.unreachable(problem.loc);
      } catch (error) {
        expect(error).toBeInstanceOf(Refused);
        expect((error as Refused).problem.errors).toEqual([problem]);
      }
    }
  });
});
