import { describe, expect, it } from 'vitest';
import type { AxisIdentification } from '../../app/api/types';
import { rowsOf, warningsOf, type Parameter } from './parameter-rows';

function parameter(change: Partial<Parameter>): Parameter {
  return {
    value: 3.106,
    unit: 'N',
    standard_error: 0.001,
    low: 3.104,
    high: 3.108,
    believed: 3.591,
    true: 3.725,
    ratio: 3.106 / 3.725,
    ...change,
  };
}

function axis(parameters: Record<string, Parameter>): AxisIdentification {
  return {
    points: [],
    residuals: [],
    curve: { velocity: [], force: [], low: null, high: null },
    sliding: { parameters, residual_rms: 0.001, residual_unit: 'N', warnings: ['v_s is unsure'] },
    presliding: null,
    ramps: [],
    warnings: ['the axis slid', 'a ramp is slow', 'v_s is unsure'],
  };
}

describe('a row', () => {
  it('has one unit for all its numbers', () => {
    const [row] = rowsOf(axis({ F_s: parameter({}) }), null);
    expect(row).toMatchObject({
      name: 'F_s',
      unit: 'N',
      believed: '3.591',
      value: '3.106',
      half: '0.0020',
      true: '3.725',
      error: '−16.6 %',
      interval: '95 % interval: 3.104 to 3.108 N',
    });
  });

  it('has stiffness and damping in the units of the Lab, whatever their size', () => {
    const [stiff] = rowsOf(axis({ sigma_0: parameter({ value: 4.2e6, unit: 'N/m' }) }), null);
    expect(stiff).toMatchObject({ unit: 'N/mm', value: '4200' });
    const [damped] = rowsOf(axis({ sigma_1: parameter({ value: 90, unit: 'N s/m' }) }), null);
    expect(damped).toMatchObject({ unit: 'N s/mm', value: '0.09000' });
  });

  it('says so where the data determine nothing', () => {
    const unknown = parameter({ standard_error: null, low: null, high: null });
    const [row] = rowsOf(axis({ v_s: unknown }), null);
    expect(row).toMatchObject({ half: 'unknown', interval: 'The data do not determine it.' });
  });

  it('has no error where the truth is not known, as on a real motor', () => {
    const [row] = rowsOf(axis({ f_0: parameter({ true: null, believed: null }) }), null);
    expect(row).toMatchObject({ true: '–', error: '–', believed: '–' });
  });

  it('writes no more digits than an interval needs', () => {
    const [sharp] = rowsOf(axis({ F_s: parameter({ low: 3.10599, high: 3.10601 }) }), null);
    expect(sharp?.half).toBe('<0.001');
    const near = parameter({ value: 1e-6, low: -4e-5, high: 4.2e-5, believed: null, true: null });
    expect(rowsOf(axis({ f_0: near }), null)[0]).toMatchObject({
      unit: 'µN',
      value: '1.00',
      half: '41',
    });
  });

  it('is shown with the one of an earlier result', () => {
    const [row] = rowsOf(axis({ F_s: parameter({}) }), axis({ F_s: parameter({ value: 3 }) }));
    expect(row).toMatchObject({ other: '3.000', change: '+3.5 %' });
  });
});

it('says every warning once', () => {
  expect(warningsOf(axis({}))).toEqual(['The axis slid', 'A ramp is slow', 'v_s is unsure']);
});
