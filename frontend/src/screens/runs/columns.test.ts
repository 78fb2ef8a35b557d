import { expect, it } from 'vitest';
import type { Run, Scenario } from '../../app/api/types';
import { served } from '../../app/fields/fields.svelte';
import { columnChoices, columnOf, figureOf, figureText } from './columns';
import { boundsOf, withBounds } from './search-text';

const GAIN = 'variants.*.controller.x.k_p';
const entries = { [GAIN]: { label: 'k_p x', unit: 'N/mm', factor: 1e-3 } } as never;
served.scenario = { ...served.scenario, fields: entries };

const run = {
  metrics: { 'B.x.max_abs_following_error': 2.5e-6 },
  differences: [{ path: 'variants.B.controller.x.k_p', shipped: 200_300, value: 4e5 }],
} as unknown as Run;
const shipped = {
  variants: { A: { controller: { x: { k_p: 200_300 } } } },
} as unknown as Scenario;

it('a column is a metric or a field: what was set, else what ships', () => {
  const [error, gain] = ['x.max', GAIN].map((id) => columnOf(id, entries));
  if (!error || !gain) throw new Error('no column');
  expect([error.label, error.unit]).toEqual(['max e_x', 'µm']);
  expect(figureText(error, figureOf(error, run, 'B', null))).toBe('2.50');
  expect(figureText(error, figureOf(error, run, 'A', null))).toBe('–');
  expect(figureText(gain, figureOf(gain, run, 'B', shipped))).toBe('400');
  expect(figureText(gain, figureOf(gain, run, 'A', shipped))).toBe('200.3');
  expect(columnOf('unknown', entries)).toBeNull();
  expect(columnChoices(entries).map(({ name }) => name)).toContain('k_p x');
});

it('margins are in decibels and degrees, also in the search', () => {
  const [gain, phase] = ['x.gain_margin', 'y.phase_margin'].map((id) => columnOf(id, entries));
  if (!gain?.metric || !phase?.metric) throw new Error('no column');
  expect([gain.label, gain.unit, phase.label, phase.unit]).toEqual(['GM_x', 'dB', 'PM_y', '°']);
  expect(figureText(gain, 2)).toBe('6.02');
  expect(figureText(phase, Math.PI / 6)).toBe('30.0');
  const [x, y] = ['B.x.gain_margin', 'B.y.phase_margin'];
  let query = withBounds('', x, { low: 2, high: null }, gain.metric);
  query = withBounds(query, y, { low: null, high: Math.PI / 6 }, phase.metric);
  expect(query).toBe('B.x.gain_margin>6.02dB B.y.phase_margin<30deg');
  expect(boundsOf(query, x).low).toBeCloseTo(2, 3);
  expect(boundsOf(query, y).high).toBeCloseTo(Math.PI / 6, 12);
  expect(columnChoices(entries).find(({ name }) => name === 'GM_x')?.detail).toBe(
    'gain margin, dB',
  );
});

it('bounds are words of the search, others stay', () => {
  const scale = { unit: 'µm', shown: (value: number) => value * 1e6 };
  const query = withBounds(
    'tag:rig B.x.max<9um',
    'B.x.max',
    { low: 1.23456e-6, high: 5e-6 },
    scale,
  );
  expect(query).toBe('tag:rig B.x.max>1.23um B.x.max<5um');
  expect(boundsOf(query, 'B.x.max').high).toBeCloseTo(5e-6, 12);
  expect(boundsOf(query, 'B.y.max')).toEqual({ low: null, high: null });
  expect(withBounds(query, 'B.x.max', { low: null, high: null }, scale)).toBe('tag:rig');
  expect(boundsOf('B.x.max<=2e-6', 'B.x.max').high).toBe(2e-6);
});
