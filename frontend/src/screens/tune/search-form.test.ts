import { expect, it, vi } from 'vitest';
import type { Scenario } from '../../app/api/types';
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
  form.searchObserver(true);
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

it('searches no observer where there is none', () => {
  const form = formWith({ variant: 'A' });
  form.searchObserver(true);
  expect(form.tuneBody(question)).toMatchObject({ also: {} });
});

it('turns decibels into factors and back', () => {
  expect(decibels(factorOf(6))).toBeCloseTo(6);
  expect(factorOf(20)).toBe(10);
});
