import { describe, expect, it } from 'vitest';
import type { Scenario } from '../../app/api/types';
import '../../app/fields/example-fields';
import {
  bodyOf,
  compensated,
  compensates,
  complaint,
  complaints,
  defaults,
  formOf,
  ratesOf,
  speedsOf,
} from './experiment-form';

const DEFAULT = defaults();
const scenario = { name: 'circle', variants: { A: {}, B: {} } } as unknown as Scenario;

describe('speeds', () => {
  it('go from the slowest to the fastest, each as far from the next in ratio', () => {
    const speeds = speedsOf({ ...DEFAULT, slowest: 0.001, fastest: 0.1, speeds: 5 });
    expect(speeds).toEqual([0.001, 0.003162, 0.01, 0.03162, 0.1]);
  });

  it('or in mm/s', () => {
    const form = {
      ...DEFAULT,
      slowest: 0.01,
      fastest: 0.05,
      speeds: 5,
      spacing: 'linear' as const,
    };
    expect(speedsOf(form)).toEqual([0.01, 0.02, 0.03, 0.04, 0.05]);
  });

  it('are by default those of the server', () => {
    const speeds = speedsOf(DEFAULT);
    expect(speeds).toHaveLength(32);
    expect(speeds[0]).toBe(0.0005);
    expect(speeds[31]).toBe(0.15);
    expect(speeds[1]).toBe(0.000601);
  });
});

describe('the request', () => {
  it('names a run and what is read of it, and is read back', () => {
    const form = { ...DEFAULT, by: 'run' as const, run: 'r-abcdefghijkl', force: 'Kraft', mass: 5 };
    const body = bodyOf(form, scenario, {});
    expect(body).toMatchObject({ run: form.run, record: { force: 'Kraft', mass: 5 } });
    expect(formOf({ ...body })).toMatchObject({ by: 'run', run: form.run, position: '', mass: 5 });
    expect(bodyOf({ ...form, by: 'experiment' }, scenario, {})).not.toHaveProperty('run');
  });

  it('has the changes of the Lab, but for its motion', () => {
    const changes = {
      'plant.x.mass': 6,
      'trajectory.radius': 0.02,
      trajectory: { kind: 'circle' },
      'variants.A.controller.x.k_p': 1e5,
      seed: 3,
    };
    const body = bodyOf(DEFAULT, scenario, changes);
    expect(body.set).toEqual({
      'plant.x.mass': 6,
      'variants.A.controller.x.k_p': 1e5,
      seed: 3,
    });
  });

  it('has another motor in place of changes of the present one', () => {
    const form = { ...DEFAULT, motor: 'matched' };
    expect(bodyOf(form, scenario, { 'plant.x.mass': 6, seed: 3 }).set).toEqual({
      plant: 'matched',
      seed: 3,
    });
  });

  it('leaves out variants that the scenario does not have', () => {
    const body = bodyOf({ ...DEFAULT, variant: 'B', applyTo: 'C' }, scenario, {});
    expect([body.variant, body.apply_to]).toEqual(['B', null]);
  });
});

describe('rates', () => {
  it('are read with spaces or semicolons between them', () => {
    expect(ratesOf('20 50; 100')).toEqual([20, 50, 100]);
    expect(ratesOf(' 12,5 ')).toEqual([12.5]);
    expect(ratesOf('20 fast')).toBeNull();
    expect(ratesOf('  ')).toBeNull();
  });
});

describe('what the server refuses', () => {
  const speeds = [0.001, 0.5];

  it('names the speed, and lengths in the unit of the screen', () => {
    const text = complaint(
      {
        loc: 'speeds.1',
        message: 'needs 234.5 mm on x to speed up; the stroke of x is 170 mm',
        value: 0.5,
        bounds: { maximum: 0.412 },
        unit: 'm/s',
      },
      { speeds },
    );
    expect(text).toBe(
      '500 mm/s needs 234.5 mm on x to speed up; the stroke of x is 170 mm. Allowed: ≤ 412 mm/s.',
    );
  });

  it('counts items as they are', () => {
    const field = { loc: 'speeds', message: 'has too few items', value: 3, unit: 'items' };
    expect(complaint({ ...field, range: '5 or more' }, { speeds })).toBe(
      'speeds 3: has too few items. Allowed: 5 or more items.',
    );
  });

  it('says once what holds for many speeds', () => {
    const field = { message: 'is out of range', value: 0, bounds: { minimum: 1e-4 }, unit: 'm/s' };
    const fields = [1, 2, 3].map((k) => ({ ...field, loc: `speeds.${String(k)}` }));
    const texts = complaints(fields, { speeds: [0.001, 0, 0, 0] });
    expect(texts).toHaveLength(1);
  });

  it('leaves a range in words as it is', () => {
    const field = { loc: 'speeds.0', message: 'is too fast', range: 'none on this stroke' };
    expect(complaint(field, { speeds })).toBe(
      '1.00 mm/s is too fast. Allowed: none on this stroke.',
    );
  });

  it('names the field as the screen does', () => {
    const field = {
      loc: 'time_max',
      message: 'is out of range',
      value: 0,
      bounds: { exclusive_minimum: 0 },
      unit: 's',
    };
    expect(complaint(field, { speeds })).toBe('time of each 0: is out of range. Allowed: > 0 s.');
  });
});

it.each(['log', 'linear'] as const)('shows what was asked for, with %s speeds', (spacing) => {
  const form = {
    ...DEFAULT,
    motor: 'matched',
    axis: 'y' as const,
    variant: 'A',
    applyTo: 'B',
    slowest: 0.002,
    speeds: 9,
    spacing,
    timeMax: 1,
    pitchesMax: 3,
    rates: [50],
    places: 4,
  };
  const asked = JSON.parse(JSON.stringify(bodyOf(form, scenario, {}))) as Record<string, unknown>;
  expect({ ...DEFAULT, ...formOf(asked) }).toEqual(form);
  const bare = JSON.parse(JSON.stringify(bodyOf(DEFAULT, scenario, {}))) as Record<string, unknown>;
  expect({ ...form, ...formOf(bare) }).toEqual(DEFAULT);
});

it('switches the compensation on that is compared, where there is one', () => {
  const law = (name: string) => ({ controller: { compensation: { law: name, enabled: false } } });
  const variants = { A: law('off'), B: law('observer') };
  const both = { ...scenario, variants } as unknown as Scenario;
  expect(compensates(both, {}, 'B')).toBe(true);
  expect(compensates(both, { 'variants.B.controller.compensation.law': 'off' }, 'B')).toBe(false);
  expect(compensated(both, { seed: 3 }, 'A')).toEqual({ seed: 3 });
  expect(compensated(both, {}, 'B')).toEqual({
    'variants.B.controller.compensation.enabled': true,
  });
});
