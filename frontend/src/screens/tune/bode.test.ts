import { expect, it } from 'vitest';
import type { MeasuredLoop } from '../../app/api/types';
import { gainMarginMark, marksOf, measuredText, phaseMarginMark, signalText } from './bode';
import type { LookedAt } from './loop-store.svelte';

// |L| = 100/f, arg L = -90° - f/4°: one at 100 Hz with 65° left, -180° at 360 Hz.
const frequency = Array.from({ length: 901 }, (_, k) => 10 ** (k / 300));
const open = {
  magnitude: frequency.map((f) => 100 / f),
  phase: frequency.map((f) => (-(90 + f / 4) * Math.PI) / 180),
};
const figures = {
  crossover: 100,
  gain_margin: 3.6,
  phase_margin: (65 * Math.PI) / 180,
};
const looked = { response: { frequency, open }, figures } as unknown as LookedAt;

it('draws the gain margin where the phase of L is −180°', () => {
  const [mark] = gainMarginMark(looked);
  expect(mark?.at).toBeCloseTo(360, 0);
  expect(mark?.between).toEqual([1 / 3.6, 1]);
  expect(mark?.label).toBe('gain margin 11.1 dB');
  expect(marksOf(looked, 'open')).toContainEqual(mark);
});

it('draws the phase margin where the magnitude of L is one', () => {
  const [mark] = phaseMarginMark(looked);
  expect(mark?.at).toBeCloseTo(100, 1);
  expect(mark?.between?.[1]).toBeCloseTo(-115, 5);
  expect(mark?.label).toBe('phase margin 65.0°');
});

it('draws no margin of a loop without one', () => {
  const none = { ...looked, figures: { ...figures, gain_margin: null, phase_margin: null } };
  expect(gainMarginMark(none as unknown as LookedAt)).toEqual([]);
  expect(phaseMarginMark(none as unknown as LookedAt)).toEqual([]);
});

it('shows the interval of the gain margin downwards from its lower end', () => {
  const gain = { value: 0.033, interval: [0.0315, 0.034], model: null };
  const measured = {
    margins: { gain_reduction: gain },
    velocity: 0.04,
    seconds: 60,
    crossings: [],
  } as unknown as MeasuredLoop;
  expect(measuredText(measured)).toContain('and downwards 29.6 (29.4 to 30.0) dB');
});

it('says what half of the force changes, where that was measured', () => {
  const measured = {
    margins: { crossover: { value: 50, interval: [49, 52] } },
    velocity: 0.04,
    seconds: 60,
    crossings: [],
    half_force: { gain: 1.0412, phase: 0, interval: 0.011 },
  } as unknown as MeasuredLoop;
  expect(measuredText(measured)).toContain('With half the force the plant is 1.041 ± 0.011 times');
  expect(measuredText({ ...measured, half_force: null })).not.toContain('half');
});

const measured = { velocity: 0.04, seconds: 60, crossings: [] };

it('names the signal of a measurement, but for the usual one', () => {
  const loop = { ...measured, margins: {} } as never;
  const of = (signal: string) => measuredText(loop, signalText({ signal }));
  expect(of('multisine')).toBe('Measured in 60.0 s of sliding at 40.0 mm/s.');
  expect(of('stepped-sine')).toContain('Measured by stepped sines in 60.0 s');
  expect(signalText(undefined)).toBe('');
});

it('says that a margin is not there once all is measured', () => {
  const none = { value: null, interval: null };
  const crossover = { value: 50, interval: null };
  const partial = { ...measured, margins: { crossover, gain_margin: none } } as never;
  expect(measuredText(partial)).toContain('mm/s: crossover 50.0 Hz.');
  const known = { ...crossover, interval: [49, 51] };
  const whole = { ...measured, margins: { crossover: known, gain_margin: none } } as never;
  expect(measuredText(whole)).toContain(
    'crossover 50.0 (49.0 to 51.0) Hz, no phase margin, no gain',
  );
});
