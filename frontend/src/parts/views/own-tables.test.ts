import { expect, test } from 'vitest';

import { ownTables } from './own-tables';

const FIGURES = {
  per_sign: { unit: 'm', description: 'c_s, m' },
  explained: { unit: '', description: 'Share' },
};

test('records with the same figures stand side by side, with their units', () => {
  const shares = (per_sign: number) => ({ per_sign, explained: 0.5, lags: [1, 2, 3] });
  const document = {
    variants: {
      A: { x: shares(15e-6), y: shares(13e-6) },
      B: { x: shares(5e-8), y: shares(1e-7) },
    },
    note: 'of 2 laps',
  };
  const [alone, table, ...more] = ownTables(document, FIGURES, ['A', 'B']);
  expect(more).toEqual([]);
  expect(alone?.rows.map(({ name, cells }) => [name, ...cells])).toEqual([['note', 'of 2 laps']]);
  expect(table?.heads).toEqual([
    { name: 'A x', variant: 'A' },
    { name: 'A y', variant: 'A' },
    { name: 'B x', variant: 'B' },
    { name: 'B y', variant: 'B' },
  ]);
  expect(table?.rows.map(({ name, unit, cells }) => [name, unit, ...cells])).toEqual([
    ['per sign', 'µm', '15.0', '13.0', '0.0500', '0.100'],
    ['explained', '', '0.500', '0.500', '0.500', '0.500'],
    ['lags', '', '3 values', '3 values', '3 values', '3 values'],
  ]);
});

test('a missing number is a dash, and a list of tables has a column for each', () => {
  const [table] = ownTables({ peaks: [{ per_sign: null }, { per_sign: 2e-3 }] }, FIGURES, []);
  expect(table?.heads.map(({ name }) => name)).toEqual(['1', '2']);
  expect(table?.rows[0]?.cells).toEqual(['–', '2.00']);
});
