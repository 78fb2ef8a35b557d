import { expect, it } from 'vitest';
import type { RunDetail } from '../../app/api/types';
import {
  errorScopes,
  measuredWindow,
  pageOf,
  planePage,
  planeRange,
  withoutPlane,
} from './run-window';

const NAMES = [
  'x.position_reference',
  'y.position_reference',
  'A.x.following_error',
  'B.x.following_error',
  'B.x.velocity',
];
const run = {
  ticks: 21_000,
  period: 0.0005,
  duration: 10.5,
  first_tick: 0,
  variants: ['A', 'B'],
  result: { window: { start: 4.5, end: 10.5 } },
  columns: NAMES.map((name) => ({ name, unit: name.includes('velocity') ? 'm/s' : 'm' })),
} as unknown as RunDetail;

it('the plane shows the window of the metrics, or all of what is looked at', () => {
  expect(planeRange(run, null)).toEqual({ from: 4.5, to: 10.5 });
  expect(planeRange(run, { from: 1, to: 2 })).toEqual({ from: 1, to: 2 });
  const long = { ...run, ticks: 480_000, duration: 240, result: {} } as RunDetail;
  expect(planeRange(long, null)).toEqual({ from: 0, to: 240 });
  expect(planeRange(long, { from: 10, to: 200 })).toEqual({ from: 10, to: 200 });
});

it('of a run whose beginning has gone, times count from its first sample', () => {
  const late = { ...run, first_tick: 80_000, result: { window: { start: 44.5, end: 50.5 } } };
  expect(planeRange(late, null)).toEqual({ from: 4.5, to: 10.5 });
  expect(measuredWindow(late)).toEqual({ start: 4.5, end: 10.5 });
  expect(measuredWindow({ ...late, result: {} })).toBeNull();
});

it('without a reference there is no plane, and it is said which', () => {
  expect(withoutPlane(run)).toBe('');
  expect(withoutPlane({ columns: [] })).toBe('');
  const measured = { ...run, columns: run.columns.filter(({ name }) => !name?.startsWith('y.')) };
  expect(withoutPlane(measured)).toContain('it has no y.position_reference.');
  expect(planeRange(measured, { from: 1, to: 2 })).toBeNull();
});

it('scopes show the errors of a run, or what else it has', () => {
  const channels = (of: RunDetail) => errorScopes(of).map((scope) => scope.channels);
  expect(channels(run)).toEqual([['A.x.following_error', 'B.x.following_error']]);
  const columns = [{ name: 'force', unit: 'N' }];
  expect(channels({ ...run, variants: [], columns } as unknown as RunDetail)).toEqual([['force']]);
});

it('the plane turns its pages while a moment moves, and stays in between', () => {
  const long = { ...run, duration: 240 };
  expect(planePage(pageOf(5.9), long)).toEqual(planePage(pageOf(0), long));
  expect(planePage(pageOf(0), long)).toEqual({ from: 0, to: 12 });
  expect(planePage(pageOf(100), long)).toEqual({ from: 93, to: 105 });
  expect(planePage(pageOf(240), long)).toEqual({ from: 228, to: 240 });
  expect(planePage(pageOf(10.5), run)).toEqual({ from: 0, to: 10.5 });
});
