import { expect, test } from 'vitest';
import type { RunDetail } from '../../../app/api/types';
import {
  changesOf,
  choiceOf,
  controllerOptions,
  describe,
  differing,
  errorRows,
  errorSeries,
  filled,
  motorRows,
  type MinuteDocument,
} from './minute';

const RUN = {
  id: 'r-1',
  variants: ['A', 'B'],
  duration: 10.5,
  scenario_document: { variants: { A: {}, B: {} } },
} as unknown as RunDetail;

const OPTIONS = controllerOptions(
  { controllers: [{ name: 'lugre-reference', description: 'On the reference' }] },
  [
    { value: 'off', label: 'no compensation', description: '', unit: '' },
    { value: 'my-law', label: 'my law', description: '', unit: '' },
  ],
  'LuGre observer',
);

const PREDICTED = { value: 0.8846e-6, low: 0.0644e-6, high: 1.67e-6 };
const AXIS = {
  max_recorded: 20.5e-6,
  rms_recorded: 0,
  max_predicted: PREDICTED,
  rms_predicted: PREDICTED,
  motor: {
    sigma_0: { value: 2.1e6, low: 1.9e6, high: 2.3e6, believed: 2e6, unit: 'N/m' },
    f_0: { value: -0.5, low: -0.7, high: -0.3, believed: 0, unit: 'N' },
  },
} as unknown as MinuteDocument['axes'][string];

test('what is left open is what the server takes: the second controller, the whole run', () => {
  expect(filled({}, RUN)).toEqual({ variant: 'A', other: 'B', set: {}, start: 0, end: 10.5 });
  const single = { ...RUN, scenario_document: { variants: { A: {} } } } as unknown as RunDetail;
  expect(filled({ end: 4 }, single)).toMatchObject({ other: 'A', end: 4 });
});

test.each(OPTIONS.map(({ value }) => value))(
  'the choice “%s” comes back from its changes',
  (value) => {
    expect(choiceOf(changesOf(value, 'B'), 'B', OPTIONS)).toBe(value);
  },
);

test('a law is switched on with its choice; changes made elsewhere are no choice', () => {
  const compensation = 'variants.A.controller.compensation';
  expect(changesOf('law:my-law', 'A')).toEqual({
    [`${compensation}.law`]: 'my-law',
    [`${compensation}.enabled`]: true,
  });
  expect(choiceOf({ 'variants.B.controller.x.k_p': 1 }, 'B', OPTIONS)).toBeNull();
  expect(choiceOf({ 'variants.B.controller': 'lugre-reference' }, 'A', OPTIONS)).toBeNull();
});

test('a request differs where its meaning does', () => {
  expect(differing({}, { variant: 'A', other: null, end: null }, RUN)).toEqual([]);
  const other = { other: 'A', variant: 'B', start: 2 };
  expect(differing({}, other, RUN)).toEqual(['record', 'controller that is tried', 'stretch']);
});

test('a request is listed by what is tried, and where', () => {
  const set = { 'variants.B.controller': 'lugre-reference', 'variants.B.controller.x.k_p': 1 };
  expect(describe({ run: 'r-1', other: 'B', set, start: 2, end: 6 })).toBe(
    'B lugre-reference 2 to 6 s',
  );
});

test('errors are in micrometres, with interval and ratio', () => {
  expect(errorRows({ x: AXIS })).toEqual([
    { name: 'max |e_x|', cells: ['20.5', '0.885', '0.064 to 1.67', '0.0432'] },
    { name: 'RMS e_x', cells: ['0', '0.885', '0.064 to 1.67', '–'] },
  ]);
});

test('a quantity of the motor has one unit for all of its numbers', () => {
  expect(motorRows(AXIS)).toEqual([
    { name: 'sigma_0', unit: 'MN/m', cells: ['2.00', '2.10', '1.90 to 2.30'] },
    { name: 'f_0', unit: 'mN', cells: ['0', '−500', '−700 to −300'] },
  ]);
});

test('beside the prediction there is what is switched on', () => {
  const errors = { time: [0], recorded: [1], again: [2], predicted: [3], low: [2], high: [4] };
  const names = (recorded: boolean, again: boolean) =>
    errorSeries({ variant: 'A', other: 'B' }, errors, { recorded, again }).map(({ name }) => name);
  expect(names(true, false)).toEqual(['A recorded', 'B predicted']);
  expect(names(false, true)).toEqual(['A simulated again', 'B predicted']);
});
