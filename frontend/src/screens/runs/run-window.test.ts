import { expect, it } from 'vitest';
import type { RunDetail } from '../../app/api/types';
import {
  channelsOf,
  pageOf,
  planePage,
  planeRange,
  scopesOf,
  withoutPlane,
  zoomed,
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
  variants: ['A', 'B'],
  result: { window: { start: 4.5, end: 10.5 } },
  columns: NAMES.map((name) => ({ name, unit: name.includes('velocity') ? 'm/s' : 'm' })),
} as unknown as RunDetail;

it('a zoom stays within the run and is never shorter than can be read', () => {
  expect(zoomed({ from: -1, to: 2 }, run)).toEqual({ from: 0, to: 3 });
  expect(zoomed({ from: 9, to: 12 }, run)).toEqual({ from: 7.5, to: 10.5 });
  expect(zoomed({ from: -5, to: 15 }, run)).toBeNull();
  expect(zoomed({ from: 1, to: 1 }, run)).toEqual({ from: 1, to: 1.004 });
});

it('the plane shows the window of the metrics, or the end of what is looked at', () => {
  expect(planeRange(run, null)).toEqual({ from: 4.5, to: 10.5 });
  expect(planeRange(run, { from: 1, to: 2 })).toEqual({ from: 1, to: 2 });
  const long = { ...run, ticks: 480_000, duration: 240, result: {} } as RunDetail;
  expect(planeRange(long, null)).toEqual({ from: 228, to: 240 });
});

it('without a reference there is no plane, and it is said which', () => {
  expect(withoutPlane(run)).toBe('');
  expect(withoutPlane({ columns: [] })).toBe('');
  const measured = { ...run, columns: run.columns.filter(({ name }) => !name?.startsWith('y.')) };
  expect(withoutPlane(measured)).toContain('it has no y.position_reference.');
  expect(planeRange(measured, { from: 1, to: 2 })).toBeNull();
});

it('scopes show what the run has, of all its variants', () => {
  const scopes = scopesOf(run, 'x.velocity');
  expect(scopes.map(({ title, unit }) => [title, unit])).toEqual([
    ['Following error x', 'm'],
    ['velocity x', 'm/s'],
  ]);
  expect(scopes[0]?.traces.map(({ column, ink }) => [column, ink])).toEqual([
    ['A.x.following_error', 'a'],
    ['B.x.following_error', 'b'],
  ]);
  expect(scopes[1]?.traces.map(({ column, ink }) => [column, ink])).toEqual([
    ['B.x.velocity', 'b'],
  ]);
  expect(channelsOf(run).map(({ value }) => value)).toEqual([
    'x.position_reference',
    'y.position_reference',
    'x.velocity',
  ]);
});

it('the plane turns its pages while a moment moves, and stays in between', () => {
  const long = { ...run, duration: 240 };
  expect(planePage(pageOf(5.9), long)).toEqual(planePage(pageOf(0), long));
  expect(planePage(pageOf(0), long)).toEqual({ from: 0, to: 12 });
  expect(planePage(pageOf(100), long)).toEqual({ from: 93, to: 105 });
  expect(planePage(pageOf(240), long)).toEqual({ from: 228, to: 240 });
  expect(planePage(pageOf(10.5), run)).toEqual({ from: 0, to: 10.5 });
});
