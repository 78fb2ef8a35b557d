import { describe, expect, it } from 'vitest';
import type { MapTables, Scenario } from '../../../app/api/types';
import { placesOf, useMap, usedIn } from '../../../app/force-maps';
import {
  analyticOf,
  fraction,
  normalForce,
  peaks,
  thrust,
  type Analytic,
  analyticCurve,
  curvesOf,
  publishedOf,
  surface,
  uncertaintyBand,
} from './force-curves';

const analytic: Analytic = {
  tau: 7.2e-3,
  offset: 0,
  F_pk: 34.1,
  N_pk: 380.1,
  I_pk: 10,
  I_knee: 5.5,
  h_2: 0,
  h_3: 0,
};

const map = {
  positions: [-3.6e-3, -1.8e-3, 0, 1.8e-3, 3.6e-3],
  currents: [0, 5, 10],
  thrust: [
    [0, 0, 0],
    [0, 20, 38],
    [0, 0, 0],
    [0, -20, -38],
    [0, 0, 0],
  ],
  normal_force: [
    [0, 100, 240],
    [0, 150, 330],
    [0, 200, 410],
    [0, 150, 330],
    [0, 100, 240],
  ],
  peaks: { current: 10, peak_position: -1.8e-3 },
  uncertainty: { thrust: 0.15, normal_force: 0.1 },
  published: [
    { method: 'finite elements', thrust: 34.1, normal_force: 380.1, not_comparable: '' },
    { method: 'measured', thrust: 38.4, normal_force: 427.4, not_comparable: 'because' },
  ],
} as unknown as MapTables;

describe('the analytic map', () => {
  it('pulls towards the aligned position, where it has its normal force', () => {
    expect(thrust(analytic, -1.8e-3, 10)).toBeCloseTo(34.1);
    expect(thrust(analytic, 1.8e-3, 10)).toBeCloseTo(-34.1);
    expect(thrust(analytic, 0, 10)).toBeCloseTo(0);
    expect(normalForce(analytic, 0, 10)).toBeCloseTo(380.1);
    expect(normalForce(analytic, 3.6e-3, 10)).toBeCloseTo(0);
  });

  it('is moved by the commutation offset', () => {
    const moved = { ...analytic, offset: 0.9e-3 };
    expect(normalForce(moved, -0.9e-3, 10)).toBeCloseTo(380.1);
    expect(thrust(moved, -2.7e-3, 10)).toBeCloseTo(34.1);
    expect(thrust(moved, 0, 10)).toBeCloseTo(-34.1 * Math.SQRT1_2);
    expect(peaks(moved, 12)).toEqual(peaks(analytic, 10));
  });

  it('saturates', () => {
    expect(fraction(analytic, 10)).toBe(1);
    expect(fraction(analytic, 5)).toBeGreaterThan(0.5);
  });

  it("is a controller's where the plant has a table, and none where they all have", () => {
    const table = { x: { force_map: { kind: 'table', name: 'a' } } };
    const formula = { x: { force_map: analytic } };
    const scenario = (model: object) =>
      ({ plant: table, variants: { A: { controller: { model } } } }) as unknown as Scenario;
    expect(analyticOf(scenario(formula))).toMatchObject({ of: 'controller A', F_pk: 34.1 });
    expect(analyticOf(scenario(table))).toBeNull();
  });
});

describe('curves of a map', () => {
  it('are those of the largest currents, none at rest', () => {
    const curves = curvesOf(map, 'thrust');
    expect(curves.map(({ name }) => name)).toEqual(['10 A', '5 A']);
    expect(Array.from(curves[0]?.y ?? [])).toEqual([0, 38, 0, -38, 0]);
  });

  it('have a band as wide below zero as above', () => {
    const { low, high } = uncertaintyBand(map, 'thrust');
    expect(low[1]).toBeCloseTo(38 * 0.85);
    expect(high[3]).toBeCloseTo(-38 * 0.85);
  });

  it('are shown with the published peaks and the analytic curve', () => {
    expect(publishedOf(map, 'normal_force').map(({ x, y }) => [x[0], y[0]])).toEqual([
      [0, 380.1],
      [0, 427.4],
    ]);
    expect(analyticCurve(map, analytic, 'thrust').y[1]).toBeCloseTo(34.1);
  });

  it('are columns of the surface', () => {
    expect(surface(map, 'thrust')[2]).toEqual([0, 38, 0, -38, 0]);
  });
});

it('a map is put into both axes of a place, and found there', () => {
  const place = placesOf(['A', 'B'])[2];
  if (!place) throw new Error('no place');
  const changes = useMap(place, 'new-design');
  expect(Object.keys(changes)).toEqual([
    'variants.B.controller.model.x.force_map',
    'variants.B.controller.model.y.force_map',
  ]);
  const axis = { force_map: changes['variants.B.controller.model.x.force_map'] };
  const scenario = { variants: { B: { controller: { model: { x: axis, y: axis } } } } };
  expect(usedIn(scenario as unknown as Scenario, place)).toBe('new-design');
});
