import { describe, expect, it } from 'vitest';
import type { Metrics, Scenario } from '../../app/api/types';
import { driveEmptyText, headline, sentence } from './headline';

const run = (a: number | null, b: number | null, y: number | null = 0) =>
  ({
    variants: {
      A: { axes: { x: { max_abs_following_error: a } } },
      B: { axes: { x: { max_abs_following_error: b }, y: { max_abs_following_error: y } } },
    },
  }) as unknown as Metrics;
const text = (metrics: Metrics | null, diverged = {}) => {
  const { variant, figure, rest } = headline(metrics, ['A', 'B'], diverged, 'No result yet');
  return `${variant} ${figure}${rest}`.trim();
};

describe('the headline', () => {
  it('says how much less B has than A', () => {
    expect(text(run(20.5e-6, 0.251e-6))).toBe('B 0.25 µm on x, 99 % less than A');
    expect(text(run(20.5e-6, 0.02e-6))).toBe('B 0.020 µm on x, 99.9 % less than A');
    expect(text(run(20.5e-6, 2.57e-6))).toBe('B 2.57 µm on x, 87 % less than A');
  });

  it('has right words where B is worse, equal or unstable', () => {
    expect(text(run(20e-6, 30e-6))).toBe('B 30.0 µm on x, 50 % more than A');
    expect(text(run(20e-6, 298e-6))).toBe('B 298 µm on x, 15 times that of A');
    expect(text(run(20e-6, 20e-6))).toBe('B 20.0 µm on x, as A has');
    expect(text(run(20e-6, null), { B: 1.25 })).toBe('B is unstable: its run ended at 1.25 s');
    expect(text(run(null, 2e-6), { A: 0.3 })).toBe(
      'B 2.00 µm on x; A is unstable, its run ended at 0.300 s',
    );
    expect(text(null, { A: 0.3, B: 0.4 })).toMatch(/^A and B are unstable/);
    expect(text(null)).toBe('No result yet');
  });

  it('is of A alone while B has not run on the drive', () => {
    expect(text(run(20.5e-6, null, null))).toBe('A 20.5 µm');
    expect(headline(run(20.5e-6, null, null), ['A', 'B'], {}, '').sizes).toEqual([20.5e-6]);
  });

  it('is of the axis on which B errs most, and names it', () => {
    expect(headline(run(2e-6, 1e-6, 3e-6), ['A', 'B'], {}, '').measure).toBe('max |e_y|');
    expect(text(run(2e-6, 1e-6, 3e-6))).toBe('B 3.00 µm on y');
    expect(headline(run(2e-6, 1e-6), ['A'], {}, '').rest).toBe('');
  });
});

describe('what A and B are', () => {
  const controller = (law: string, k_p = 1, enabled = true) => ({
    name: law,
    x: { k_p },
    compensation: { law, enabled },
  });
  const scenario = (a: object, b: object, noise = 0, schedule: object[] = []) =>
    ({
      load: { noise },
      schedule,
      variants: { A: { controller: a }, B: { controller: b } },
    }) as unknown as Scenario;
  const of = (a: object, b: object, noise = 0) => sentence(scenario(a, b, noise), ['A', 'B']);

  it('names the laws, and noise only where there is some', () => {
    expect(of(controller('off'), controller('lugre-observer'), 1)).toMatch(
      /^Same motor and motion, with the same noise: A without friction compensation, B with friction compensation \(.+\)\.$/,
    );
    expect(of(controller('off'), controller('lugre-observer'))).not.toContain('noise');
  });

  it('says what else differs, and what does not', () => {
    expect(of(controller('off'), controller('lugre-observer', 2))).toContain('k_p x differs too');
    expect(of(controller('off'), controller('off', 2))).toContain('A and B differ in k_p x.');
    expect(of(controller('off'), controller('off'))).toContain('have the same controller');
  });

  it('says what they are once all that is planned has happened', () => {
    const off = controller('lugre-observer', 1, false);
    const later = { time: 90, set: { 'variants.B.controller.compensation.enabled': true } };
    const changed = { time: 20, set: { 'load.x': 3 } };
    expect(sentence(scenario(off, off, 0, [later, changed]), ['A', 'B'])).toMatch(
      /motion: from 90 s on A with friction compensation switched off, B with lugre-observer\.$/,
    );
    expect(sentence(scenario(off, off, 0, [changed]), ['A', 'B'])).toContain(
      'motion: A and B have',
    );
    const stiff = controller('lugre-observer', 2, false);
    expect(sentence(scenario(off, stiff, 0, [later]), ['A', 'B'])).toMatch(
      /motion: A and B differ in k_p x; from 90 s on A with .+; k_p x differs too\.$/,
    );
  });
});

it('says that a motion on drives goes to its start, or ended before it, and names no Play', () => {
  expect(driveEmptyText('A', 'playing', 0)).toBe(
    'A moves to its start on the drive; curves begin there.',
  );
  expect(driveEmptyText('B', 'stopped', 0)).toBe('B ended on the drive before its start.');
});

it('does not speak of the start once the motion has begun', () => {
  expect(driveEmptyText('A', 'playing', 0.4)).toBe('A moves on the drive: no result yet');
  expect(driveEmptyText('A', 'stopped', 2.193)).toBe('A ended on the drive without a result');
});
