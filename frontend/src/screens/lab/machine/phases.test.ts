import { describe, expect, it } from 'vitest';
import type { MapTables } from '../../../app/api/types';
import { analyticMap, phaseThrusts, sentence, tableMap, turnsOf, type AxisState } from './phases';

const axis = {
  force_map: {
    kind: 'analytic',
    tau: 0.0072,
    offset: 0,
    F_pk: 34.1,
    I_pk: 10,
    I_knee: 5.5,
    h_2: 0,
    h_3: 0,
  },
};
const still: AxisState = {
  reference: 0,
  error: 0,
  currents: [0, 0, 0],
  thrust: 0,
  friction: 0,
  estimate: 0,
};

describe('thrust of the phases', () => {
  const map = analyticMap(axis);

  it('is the peak thrust at the peak current, a quarter of a pitch before aligned', () => {
    expect(map?.thrust(0.25, 10)).toBeCloseTo(34.1);
    expect(map?.thrust(0.5, 10)).toBeCloseTo(0);
    expect(map?.thrust(0.75, 10)).toBeCloseTo(-34.1);
  });

  it('is of each phase a third of a pitch later, at the position less the error', () => {
    if (!map) throw new Error('no map');
    expect(turnsOf(map, 0.0024)[1]).toBeCloseTo(0);
    const state = { ...still, reference: 0.0018, error: 0.0018, currents: [10, 10, 10] };
    const [a = 0, b = 0, c = 0] = phaseThrusts(map, state);
    expect(a).toBeCloseTo(0);
    expect(b).toBeCloseTo(-34.1 * Math.sin(Math.PI / 3));
    expect(c).toBeCloseTo(-b);
  });

  it('is read off a table where the motor has one, whose 0 is aligned', () => {
    const table = {
      geometry: { tau: 0.008 },
      positions: [-0.004, -0.002, 0, 0.002],
      currents: [0, 10],
      thrust: [
        [0, 0],
        [0, 20],
        [0, 0],
        [0, -20],
      ],
    } as unknown as MapTables;
    const read = tableMap({ force_map: { offset: 0, gain: 2 } }, table);
    expect(read.thrust(0.25, 10)).toBeCloseTo(40);
    expect(read.thrust(0.25, -5)).toBeCloseTo(20);
    expect(read.thrust(1.375, 10)).toBeCloseTo(20);
    expect(read.thrust(-0.125, 10)).toBeCloseTo(-20);
  });
});

describe('what happens, in words', () => {
  const moving = { ...still, currents: [0, 0, 1.4] };

  it('names the phase that pulls, and friction against it', () => {
    expect(sentence({ ...moving, friction: 2.6 }, [0, 0, 2.1])).toBe(
      'c pulls to the right with 2.10 N, friction of 2.60 N holds against it.',
    );
  });

  it('names friction that pushes along, and phases that pull back', () => {
    const state = { ...still, currents: [1, 1, 0], friction: 0.5 };
    expect(sentence(state, [-3, 1, 0])).toBe(
      'a pulls to the left with 3.00 N, b pulls back with 1.00 N, friction of 500 mN pushes the same way.',
    );
  });

  it('takes the estimate where friction is not measured', () => {
    const state = { ...moving, friction: Number.NaN, estimate: 2.5 };
    expect(sentence(state, [0, 0, 2.1])).toContain('estimated friction of 2.50 N holds');
  });

  it('says when nothing pulls', () => {
    expect(sentence(still, [0, 0, 0])).toBe('No phase pulls, and nothing holds.');
  });
});
