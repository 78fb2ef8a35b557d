import { afterAll, beforeAll, describe, expect, it, vi } from 'vitest';
import { ApiError } from '../../app/api/client';
import type { Scenario } from '../../app/api/types';
import { served } from '../../app/fields/fields.svelte';
import { app } from '../../app/store.svelte';
import { decibels, factorOf, SearchForm } from './search-form.svelte';

vi.hoisted(() => vi.stubGlobal('location', new URL('http://lab/')));

const controller = { disturbance_observer: { enabled: true } };
const scenario = { variants: { A: { controller: {} }, B: { controller } } } as unknown as Scenario;
app.session.info = { scenario } as NonNullable<typeof app.session.info>;
const question = { scenario, set: { plant: 'matched' } };
const formWith = (entered = {}) => {
  const form = new SearchForm('tune', {}, { variant: 1 });
  form.put(entered);
  return form;
};

it('tunes the second variant unless another is named', () => {
  expect(formWith().controller).toBe('B');
  expect(formWith({ variant: 'A' }).controller).toBe('A');
  expect(formWith({ variant: 'Q' }).controller).toBe('B');
});

it('asks for what the form says, and for a map without limits', () => {
  const form = formWith({ objective: { peak: 2 }, 'constraints.Ms': 1.8, starts: 2 });
  form.judge([1, 3]);
  form.search('disturbance_observer.bandwidth');
  const common = {
    ...question,
    variant: 'B',
    objective: { peak: 2 },
    window: { start: 1, end: 3 },
  };
  expect(form.tuneBody(question)).toEqual({
    ...common,
    constraints: { Ms: 1.8 },
    starts: 2,
    also: { 'disturbance_observer.bandwidth': [5, 300] },
  });
  expect(form.landscapeBody(question)).toEqual({ ...common, points: 64 });
  form.judge(null);
  expect(form.window).toBeNull();
});

describe('a number of the law', () => {
  const known = served.scenario;
  const field = { label: '', unit: '', factor: 1, whole: false, description: '' };
  const choices = [{ value: 'measured', label: '', description: '', unit: '' }];
  const of = { ...field, used_with: ['mine'] };
  const compensation = (entries: Record<string, object>) =>
    Object.entries(entries).map(([name, entry]) => [
      `variants.*.controller.compensation.${name}`,
      { ...of, ...entry },
    ]);
  beforeAll(() => {
    const fields = compensation({
      share: { label: 'share', unit: '%', factor: 100, usual: [0, 2] },
      slope: { usual: [5, 50] },
      level: { bounds: { exclusive_minimum: 0, maximum: 20 } },
      velocity: { choices },
      other: { used_with: ['another'] },
    });
    served.scenario = { ...known, fields: { ...known.fields, ...Object.fromEntries(fields) } };
    const mine = { controller: { compensation: { law: 'mine' } } };
    app.session.info = { scenario: { variants: { A: mine, B: mine } } } as never;
  });
  afterAll(() => {
    served.scenario = known;
    app.session.info = { scenario } as never;
  });

  it('is searched in its usual range, above zero', () => {
    const form = formWith();
    expect(form.further).toEqual(['share', 'slope', 'level'].map((name) => `compensation.${name}`));
    for (const path of form.further) form.search(path);
    form.search('compensation.level', [1, 2]);
    form.search('compensation.slope', null);
    const ranges = { 'compensation.share': [0.002, 2], 'compensation.level': [1, 2] };
    expect(form.tuneBody(question).also).toEqual(ranges);
    form.search('compensation.slope');
    expect(form.also['compensation.slope']).toEqual([5, 50]);
  });

  it('is named where its range is refused, in the unit of the screen', () => {
    const form = formWith();
    const loc = 'also.compensation.share';
    const error = { loc, message: 'is out of range', value: 3, bounds: { maximum: 2 }, unit: '1' };
    form.refuse(new ApiError({ status: 422, title: '', detail: '', errors: [error] } as never));
    expect(form.problems['']).toContain('share: Is out of range');
    expect(form.problems['']).toContain('200 %');
  });
});

it('searches no number that the controller does not use', () => {
  const form = formWith({ variant: 'A' });
  form.search('disturbance_observer.bandwidth');
  expect(form.tuneBody(question)).toMatchObject({ also: {} });
});

it('turns decibels into factors and back', () => {
  expect(decibels(factorOf(6))).toBeCloseTo(6);
  expect(factorOf(20)).toBe(10);
});
