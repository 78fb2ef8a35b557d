import { describe, expect, it, vi } from 'vitest';
import { ApiError } from '../../app/api/client';
import type { ProblemField, Scenario } from '../../app/api/types';
import { app } from '../../app/store.svelte';
import {
  compensated,
  compensates,
  ExperimentForm,
  ratesOf,
  rangeOf,
  speedsOf,
  withoutMotion,
} from './experiment-form.svelte';

vi.hoisted(() => vi.stubGlobal('location', new URL('http://lab/')));

const scenario = { name: 'circle', variants: { A: {}, B: {} } } as unknown as Scenario;
app.session.info = { scenario } as NonNullable<typeof app.session.info>;
const formWith = (entered = {}) => {
  const form = new ExperimentForm('identify', {}, { variant: 0, apply_to: 1 });
  form.put(entered);
  return form;
};
const RANGE = formWith().range;

describe('speeds', () => {
  it('go from the slowest to the fastest, each as far from the next in ratio', () => {
    const speeds = speedsOf({ ...RANGE, slowest: 0.001, fastest: 0.1, count: 5 });
    expect(speeds).toEqual([0.001, 0.003162, 0.01, 0.03162, 0.1]);
  });

  it('or in mm/s', () => {
    const range = { slowest: 0.01, fastest: 0.05, count: 5, spacing: 'linear' as const };
    const speeds = speedsOf(range);
    expect(speeds).toEqual([0.01, 0.02, 0.03, 0.04, 0.05]);
    expect(rangeOf(speeds)).toEqual(range);
  });

  it('are by default those of the server', () => {
    const speeds = speedsOf(RANGE);
    expect(speeds).toHaveLength(32);
    expect(speeds[0]).toBe(0.0005);
    expect(speeds[31]).toBe(0.15);
    expect(speeds[1]).toBe(0.000601);
  });
});

describe('the request', () => {
  it('names a run and what is read of it, and is read back', () => {
    const entered = { run: 'r-abcdefghijkl', 'record.force_column': 'Kraft', 'record.mass': 5 };
    const form = formWith(entered);
    expect(form.request).not.toHaveProperty('run');
    form.readBy('run');
    const body = form.request;
    expect(body).toMatchObject({ run: entered.run, record: { force_column: 'Kraft', mass: 5 } });
    form.readBy('experiment');
    form.restore({ ...body });
    expect([form.byRun, form.text('run'), form.number('record.mass')]).toEqual([
      true,
      entered.run,
      5,
    ]);
    form.put({});
    expect(form.request).toBeNull();
    form.readBy('experiment');
  });

  it('has the changes of the Lab, but for its motion and with another motor its plant', () => {
    const changes = {
      'plant.x.mass': 6,
      'trajectory.radius': 0.02,
      trajectory: { kind: 'circle' },
      seed: 3,
    };
    expect(withoutMotion(changes, '')).toEqual({ 'plant.x.mass': 6, seed: 3 });
    expect(withoutMotion(changes, 'matched')).toEqual({ seed: 3 });
    expect(formWith({ motor: 'matched' }).request?.set).toEqual({ plant: 'matched' });
  });

  it('leaves out controllers that the scenario does not have', () => {
    const body = formWith({ variant: 'B', apply_to: 'C' }).request;
    expect([body?.variant, body?.apply_to]).toEqual(['B', 'B']);
  });

  it.each(['log', 'linear'] as const)('comes back into the form, with %s speeds', (spacing) => {
    const entered = {
      'range.slowest': 0.002,
      'range.fastest': 0.15,
      'range.count': 9,
      'range.spacing': spacing,
      motor: 'matched',
      axis: 'y',
      variant: 'B',
      pitches_max: 3,
      'presliding.rates': [50],
    };
    const body = JSON.parse(JSON.stringify(formWith(entered).request)) as Record<string, unknown>;
    const form = formWith();
    form.restore(body);
    expect(form.entered).toEqual(entered);
    expect(form.differing(body, form.request ?? {})).toEqual([]);
    form.change({ 'range.count': 5 });
    expect(form.differing(body, form.request ?? {})).toEqual(['speeds']);
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
  const unplaced = (...errors: ProblemField[]) => {
    const form = formWith({ 'range.slowest': 0.001, 'range.fastest': 0.5, 'range.count': 2 });
    form.refuse(new ApiError({ title: '', status: 422, detail: '', errors }));
    return form.unplaced;
  };

  it('names the speed, and lengths in the unit of the screen', () => {
    const problem = {
      loc: 'speeds.1',
      message: 'needs 234.5 mm on x to speed up; the stroke of x is 170 mm',
      value: 0.5,
      bounds: { maximum: 0.412 },
      unit: 'm/s',
    };
    expect(unplaced(problem, problem)).toEqual([
      'speeds: 500 mm/s needs 234.5 mm on x to speed up; the stroke of x is 170 mm. Allowed: ≤ 412 mm/s.',
    ]);
  });

  it('counts items as they are', () => {
    const problem = { loc: 'speeds', message: 'has too few items', value: 3, unit: 'items' };
    expect(unplaced({ ...problem, range: '5 or more' })).toEqual([
      'speeds: Has too few items: 3 items. Allowed: 5 or more items.',
    ]);
  });
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
