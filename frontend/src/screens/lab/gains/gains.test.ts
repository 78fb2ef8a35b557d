import { expect, it } from 'vitest';
import type { Scenario } from '../../../app/api/types';
import { achieved, savedOn, setName, snapshot, toChange } from './gain-set';
import { scaleOf, switchNotch } from './gains';

const controller = {
  x: { k_p: 1, k_d: 2, notch: { frequency: 250, damping: 0.5, gain: 0.2 } },
  y: { k_p: 3, k_d: 4, notch: { frequency: 160, damping: 0.4, gain: 1 } },
  compensation: { law: 'off', enabled: true },
  feedforward: false,
  disturbance_observer: { enabled: false, bandwidth: 30 },
  sharing: { law: 'least-norm', overlap: 0.1 },
};
const scenario = {
  variants: { A: { label: '', controller } },
} as unknown as Scenario;

it('keeps gains, notches, laws and switches', () => {
  expect(snapshot(scenario)).toEqual({
    'variants.A.controller.x.k_p': 1,
    'variants.A.controller.x.k_d': 2,
    'variants.A.controller.x.notch.frequency': 250,
    'variants.A.controller.x.notch.damping': 0.5,
    'variants.A.controller.x.notch.gain': 0.2,
    'variants.A.controller.y.k_p': 3,
    'variants.A.controller.y.k_d': 4,
    'variants.A.controller.y.notch.frequency': 160,
    'variants.A.controller.y.notch.damping': 0.4,
    'variants.A.controller.y.notch.gain': 1,
    'variants.A.controller.compensation.law': 'off',
    'variants.A.controller.compensation.enabled': true,
    'variants.A.controller.feedforward': false,
    'variants.A.controller.disturbance_observer.enabled': false,
    'variants.A.controller.disturbance_observer.bandwidth': 30,
    'variants.A.controller.sharing.law': 'least-norm',
    'variants.A.controller.sharing.overlap': 0.1,
  });
});

it('changes only what differs and is there', () => {
  const set = {
    ...snapshot(scenario),
    'variants.A.controller.x.k_p': 9,
    'variants.B.controller.x.k_p': 9,
  };
  expect(toChange(scenario, set)).toEqual({ 'variants.A.controller.x.k_p': 9 });
});

it('adds a notch where none is and removes those that are', () => {
  expect(switchNotch(scenario, 'A', true)).toEqual({ 'variants.A.controller.y.notch.gain': 0.1 });
  expect(switchNotch(scenario, 'A', false)).toEqual({ 'variants.A.controller.x.notch.gain': 1 });
});

it('makes a name that the server takes', () => {
  expect(setName('  stiff, 2 (x/y) ')).toBe('stiff, 2 (x-y)');
  expect(setName('ÄÖ')).toBe('');
});

it('says what a set achieved, variant by variant', () => {
  const set = {
    metrics: { 'B.x.max_abs_following_error': 1.72e-6, 'A.x.max_abs_following_error': 20.5e-6 },
    margins: { 'B.x': { gain_margin: 3, phase_margin: Math.PI / 4 } },
  };
  const rows = achieved({
    name: 's',
    created: 0,
    note: '',
    scenario: 'circle',
    values: {},
    ...set,
  });
  expect(rows).toEqual([
    { variant: 'A', figures: [{ label: 'max |e_x|', number: '20.5', unit: 'µm' }] },
    {
      variant: 'B',
      figures: [
        { label: 'max |e_x|', number: '1.72', unit: 'µm' },
        { label: 'PM x', number: '45.0', unit: '°' },
      ],
    },
  ]);
});

it('writes when a set was saved', () => {
  const noon = new Date(2026, 10, 22, 14, 5).getTime() / 1e3;
  expect(savedOn(noon)).toBe('2026-11-22 14:05');
});

it('slides over the range that the server gives', () => {
  const path = 'variants.B.controller.x.k_p';
  expect(scaleOf(path)).toEqual({ least: 1e4, most: 1e7 });
});
