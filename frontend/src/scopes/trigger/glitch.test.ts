import { expect, it } from 'vitest';
import { glitchHeight } from './glitch';

const PERIOD = 5e-4;
const velocity = Array.from({ length: 400 }, (_, i) => (i < 100 ? -1 : i < 103 ? 0 : 1));
const error = velocity.map((_, i) => {
  const t = (i - 104) * PERIOD;
  const rise = t > 0 ? 8e-6 * (Math.exp(-t / 0.03) - Math.exp(-t / 0.004)) : 0;
  return 2e-6 + rise + 1e-8 * Math.sin(i);
});
const settings = { trigger: 103, count: 5e-8, period: PERIOD };

it('has the height and the sign that the analysis of runs gives', () => {
  // motionlab.analysis.glitches.glitches of the same samples.
  expect(glitchHeight(velocity, error, settings)).toBeCloseTo(5.035553367911569e-6, 15);
  const turned = (values: number[]) => values.map((value) => -value);
  expect(glitchHeight(turned(velocity), turned(error), settings)).toBeCloseTo(-5.0355534e-6, 12);
});

it('is none without a reversal, too near the start, or of an error that is not known', () => {
  const steady = velocity.map(() => 1);
  expect(glitchHeight(steady, error, settings)).toBeNull();
  expect(glitchHeight(velocity.slice(80), error.slice(80), settings)).toBeNull();
  const unknown = error.map((value, i) => (i === 300 ? Number.NaN : value));
  expect(glitchHeight(velocity, unknown, settings)).toBeNull();
});
