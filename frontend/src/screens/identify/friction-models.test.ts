import { describe, expect, it } from 'vitest';
import type { FrictionModels } from '../../app/api/types';
import type { Body } from './experiment-form.svelte';
import { modelRows, modelsRequest, verdict } from './friction-models';

const model = (name: string, label: string, error: number) => ({
  name,
  label,
  complexity: 4,
  error,
  difference: error - 0.01,
  difference_error: 0.001,
  fitted: error,
  parameters: {},
});

const result = {
  force_unit: 'N',
  models: [model('stribeck', 'Stribeck', 0.01), model('lugre', 'LuGre', 0.02)],
  selected: 'stribeck',
  among: ['stribeck'],
  describes: true,
} as unknown as FrictionModels;

describe('friction models', () => {
  it('takes run and columns of the form', () => {
    const body = { scenario: 'circle', set: {}, speeds: [], run: 'r-1', record: { mass: 5 } };
    expect(modelsRequest(body as unknown as Body, 'y', ['mine'])).toEqual({
      scenario: 'circle',
      set: {},
      run: 'r-1',
      axis: 'y',
      mass: 5,
      effects: ['mine'],
    });
    expect(modelsRequest({ ...body, run: null } as unknown as Body, 'x', [])).toBeNull();
  });

  it('has a row for each model, and the selected one', () => {
    const rows = modelRows(result);
    expect(rows.map(({ selected }) => selected)).toEqual([true, false]);
    expect(rows.map(({ error }) => error)).toEqual(['10.0 mN', '20.0 mN']);
  });

  it('says what is selected, or what remains', () => {
    expect(verdict(result)).toBe('Stribeck');
    const unsure = { ...result, selected: null, among: ['stribeck', 'lugre', 'gms'] };
    expect(verdict(unsure)).toBe('cannot tell: Stribeck, LuGre');
    const none = '; none of the models describes this friction';
    expect(verdict({ ...result, describes: false })).toBe(`Stribeck${none}`);
    expect(verdict({ ...unsure, describes: false })).toBe(`cannot tell: Stribeck, LuGre${none}`);
  });
});
