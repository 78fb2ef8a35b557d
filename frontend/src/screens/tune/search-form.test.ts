import { expect, it } from 'vitest';
import type { Scenario } from '../../app/api/types';
import {
  complaint,
  decibels,
  defaults,
  factorOf,
  formOf,
  landscapeBody,
  tuneBody,
  variantOf,
} from './search-form';

const controller = { disturbance_observer: { enabled: true } };
const scenario = { variants: { A: { controller: {} }, B: { controller } } } as unknown as Scenario;
const DEFAULT = defaults();
const source = { scenario, set: { plant: 'matched' } };

it('tunes the second variant unless another is named', () => {
  expect(variantOf(DEFAULT, scenario)).toBe('B');
  expect(variantOf({ ...DEFAULT, variant: 'A' }, scenario)).toBe('A');
  expect(variantOf({ ...DEFAULT, variant: 'Q' }, scenario)).toBe('B');
});

it('asks for what the form says', () => {
  const form = { ...DEFAULT, window: [1, 3] as const, weights: { peak: 2 }, observer: true };
  expect(tuneBody(form, source, scenario)).toMatchObject({
    set: { plant: 'matched' },
    variant: 'B',
    axis: 'both',
    objective: { peak: 2 },
    bounds: { k_p: [1e4, 3e7], k_d: [1e2, 1e5] },
    window: { start: 1, end: 3 },
    also: { 'disturbance_observer.bandwidth': [5, 300] },
    constraints: { gain_margin: 2, Ms: null },
  });
  expect(landscapeBody(form, source)).toMatchObject({ variant: 'B', points: 64 });
});

it('searches no observer where there is none', () => {
  const form = { ...DEFAULT, observer: true, variant: 'A' };
  expect(tuneBody(form, source, scenario)).toMatchObject({ also: {} });
});

it('names the range that is the wrong way round', () => {
  const field = {
    loc: 'bounds.k_p',
    message: 'the lower end must lie below the upper one',
    value: '1e+06 to 100000',
    range: '',
    unit: 'N/m',
  };
  expect(complaint(field)).toBe('range of k_p: The lower end must lie below the upper one.');
});

it('turns decibels into factors and back', () => {
  expect(decibels(factorOf(6))).toBeCloseTo(6);
  expect(factorOf(20)).toBe(10);
});

it('shows what was asked for', () => {
  const form = {
    ...DEFAULT,
    variant: 'B',
    axis: 'x' as const,
    weights: { peak: 1, effort: 0.5 },
    limits: { ...DEFAULT.limits, Ms: 1.8, force: null },
    k_p: [2e4, 1e6] as const,
    observer: true,
    plants: ['matched'],
    window: [1, 3] as const,
    starts: 2,
    evaluations: 40,
  };
  const asked = JSON.parse(JSON.stringify(tuneBody(form, source, scenario))) as object;
  expect({ ...DEFAULT, ...formOf(asked as Record<string, unknown>) }).toEqual(form);
  const bare = JSON.parse(JSON.stringify(tuneBody(DEFAULT, source, scenario))) as object;
  expect({ ...form, ...formOf(bare as Record<string, unknown>) }).toEqual({
    ...DEFAULT,
    variant: 'B',
  });
  // A landscape has no limits, so those of the form stay.
  const map = landscapeBody(DEFAULT, source) as Record<string, unknown>;
  expect({ ...form, ...formOf(map) }).toMatchObject({
    limits: form.limits,
    starts: 2,
    axis: 'both',
  });
});
