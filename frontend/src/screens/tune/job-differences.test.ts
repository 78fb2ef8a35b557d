import { describe, expect, it } from 'vitest';
import type { Scenario } from '../../app/api/types';
import { inlineScenarioOf, wholeOf } from '../../app/jobs/job-request';
import { loopOf, otherWords, othersOf } from './job-differences';

const ALL = ['motor', 'load', 'motion', 'controller', 'gains'] as const;
const NOW = {
  plant: { name: 'nominal', x: { mass: 10 } },
  load: { x: 0 },
  trajectory: { kind: 'circle' },
  variants: {
    A: { label: 'PD', controller: { name: 'pd', x: { k_p: 1, k_d: 2 } } },
    B: { label: 'LuGre', controller: { name: 'lugre', x: { k_p: 1, k_d: 2 }, feedforward: true } },
  },
} as unknown as Scenario;
const MATCHED = { name: 'matched', x: { mass: 11 } };

const changed = (set: Record<string, string | number | boolean>, parts = {}) =>
  wholeOf({ scenario: NOW, set }, parts);

describe('a job is of the present loop', () => {
  it('where nothing that matters differs', () => {
    const elsewhere = changed({ 'variants.A.controller.x.k_p': 9, 'variants.B.label': 'mine' });
    expect(othersOf(elsewhere, NOW, 'B')).toEqual(new Set());
  });

  it('whether gains came as changes or stand in the scenario', () => {
    const set = { 'variants.B.controller.x.k_p': 5 };
    const baked = { scenario: changed(set), set: {} };
    expect(othersOf(wholeOf(baked, {}), changed(set), 'B')).toEqual(new Set());
  });

  it('but not with other gains, another motor, or another controller', () => {
    const others = (set: Record<string, string | number | boolean>) => [
      ...othersOf(changed(set), NOW, 'B'),
    ];
    expect(others({ 'variants.B.controller.x.k_d': 3 })).toEqual(['gains']);
    expect(others({ 'plant.x.mass': 11 })).toEqual(['motor']);
    expect(others({ plant: 'matched' })).toEqual(['motor']);
    expect(others({ 'variants.B.controller.feedforward': false })).toEqual(['controller']);
    expect([...othersOf(NOW, NOW, 'C')]).toEqual(['controller']);
  });

  it('where a motor is known by its name only', () => {
    const live = wholeOf(
      { scenario: NOW, set: { plant: 'matched' } },
      { 'plant=matched': MATCHED },
    );
    expect(othersOf(changed({ plant: 'matched' }), live, 'B').has('motor')).toBe(false);
  });
});

it('says of what a job was', () => {
  const then = changed({ plant: 'matched', 'variants.B.controller.x.k_p': 5 });
  expect(otherWords(then, NOW, 'B', ALL)).toBe('another motor (matched) and other gains');
  expect(otherWords(then, NOW, 'B', ['motion'])).toBe('');
  const heavier = changed({ 'plant.x.mass': 11 });
  expect(otherWords(heavier, NOW, 'B', ALL)).toBe('the motor nominal with other numbers than now');
});

it('knows only requests that carry their scenario', () => {
  expect(inlineScenarioOf({ scenario: 'circle' })).toBeNull();
  expect(inlineScenarioOf({ scenario: NOW })).toEqual({ scenario: NOW, set: {} });
});

it('finds of which loop a sweep was, or tells it beside the likest', () => {
  const chosen = changed({ 'variants.B.controller.x.k_p': 5 });
  expect(loopOf(NOW, NOW, chosen, 'B').of).toBe('present');
  expect(loopOf(chosen, NOW, chosen, 'B').of).toBe('chosen');
  const moved = changed({ 'trajectory.kind': 'rhombus' });
  expect(loopOf(moved, NOW, chosen, 'B').of).toBe('present');
  const then = changed({ plant: 'matched', 'variants.B.controller.x.k_p': 5 });
  expect(loopOf(then, NOW, chosen, 'B').reason).toBe('of another motor (matched)');
  expect(loopOf(then, NOW, null, 'B').reason).toBe('of another motor (matched) and other gains');
});
