import { describe as group, expect, it } from 'vitest';
import type { IdentificationPlan } from '../../app/api/types';
import { describe, doing, pitchesOf } from './experiment-text';

function plan(...pitches: number[]): IdentificationPlan {
  const motions = pitches.map((count) => ({ speed: 0.01, pitches: count, time: 1 }));
  return { simulated_time: 1, simulated_time_max: 10, known: {}, axes: { x: motions }, ramps: 0 };
}

it('tells over how many pole pitches the force is averaged', () => {
  expect(pitchesOf(plan(1, 1))).toBe('one whole pole pitch');
  expect(pitchesOf(plan(3, 3))).toBe('3 whole pole pitches');
  expect(pitchesOf(plan(1, 4, 2))).toBe('1 to 4 whole pole pitches');
});

it('tells what goes on', () => {
  expect(doing({ axis: 'x', step: 'sliding', done: 11, count: 32 })).toBe(
    'x: uniform motion 12 of 32, there and back',
  );
  expect(doing({ axis: 'y', step: 'presliding', done: 0, count: 42 })).toBe(
    'y: force ramp 1 of 42',
  );
});

group('a record', () => {
  it('is named by axis and motor', () => {
    expect(describe({ axis: 'both', scenario: { plant: { name: 'nominal' } } })).toBe(
      'x and y, nominal',
    );
    expect(describe({ axis: 'x', scenario: 'circle', set: { plant: 'matched' } })).toBe(
      'x, matched',
    );
    expect(describe({})).toBe('x and y');
  });
});
