import { describe, expect, it } from 'vitest';
import { holdMetrics, NO_METRICS, tallyMetrics } from './metrics';

const PERIOD = 5e-4;
const BAND = 1e-6;

/** Following errors over a window, m, from micrometres. */
const errors = (...values: number[]) => {
  return (tick: number) => (values[tick] as number) * 1e-6;
};

describe('metrics of holds', () => {
  it('are null without a hold', () => {
    expect(Object.values(holdMetrics(errors(1, 2), [], BAND, PERIOD))).toEqual([
      null,
      null,
      null,
      null,
    ]);
  });

  it('take the last fifth, the last tick outside, and what lies past the target', () => {
    const error = errors(9, 5, -3, 2, 0.5, 0.2, 0.1, 0.1, 0.4, 0.3);
    const figures = holdMetrics(error, [[0, 10, 2e-3]], BAND, PERIOD);
    expect(figures.steady_state_error).toBeCloseTo(4e-7, 12);
    expect(figures.settling_time).toBeCloseTo(4 * PERIOD, 12);
    // After a move forward, a negative error is beyond.
    expect(figures.overshoot).toBeCloseTo(3e-6, 12);
    expect(figures.relative_overshoot).toBeCloseTo(1.5e-3, 12);
  });

  it('have no settling time where a hold ends outside the band', () => {
    const holds = [[0, 2, 1e-3] as const, [2, 4, -1e-3] as const];
    expect(holdMetrics(errors(0, 0, 0, 2), holds, BAND, PERIOD).settling_time).toBeNull();
    expect(holdMetrics(errors(0, 2, 0, 0), holds, BAND, PERIOD).settling_time).toBeNull();
    const settled = holdMetrics(errors(2, 0, 0, 0), holds, BAND, PERIOD);
    expect(settled.settling_time).toBeCloseTo(PERIOD, 12);
  });

  it('have no overshoot where nothing moved', () => {
    const figures = holdMetrics(errors(1, 1), [[0, 2, 0]], BAND, PERIOD);
    expect([figures.overshoot, figures.relative_overshoot]).toEqual([null, null]);
  });
});

it('a tally gives every other metric', () => {
  const tally: Record<string, number> = {
    error_min: -3,
    error_max: 2,
    error_sum: 8,
    error_squares: 16,
    error_times: 10,
    saturated: 1,
  };
  const figures = tallyMetrics((name) => tally[name] ?? 0, 4, PERIOD);
  expect(figures).toMatchObject({
    max_abs_following_error: 3,
    mean_following_error: 2,
    rms_following_error: 2,
    itae: 10 * PERIOD,
    saturated_fraction: 0.25,
  });
  expect(Object.keys(NO_METRICS)).toEqual([
    ...Object.keys(figures),
    'steady_state_error',
    'settling_time',
    'overshoot',
    'relative_overshoot',
  ]);
});
