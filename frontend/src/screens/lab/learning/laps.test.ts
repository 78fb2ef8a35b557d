import { describe, expect, it } from 'vitest';
import type { Learning, LearnLap, Scenario } from '../../../app/api/types';
import {
  diverges,
  forgetting,
  growthChart,
  knownText,
  type Laps,
  lapRows,
  lapsChart,
  overLap,
} from './laps';

const lap = (peak: number): LearnLap => ({
  peak,
  rms: peak / 2,
  true_peak: peak / 4,
  true_rms: peak / 8,
  force: 0,
  gain: 0.6,
  went_back: false,
});

const laps: Laps = { x: [lap(4e-6), lap(8e-7)], y: [lap(2e-6), lap(4e-7)] };

const prediction = {
  frequency: [1, 10, 100],
  motor: [0.4, 0.5, 1.2],
  model: [0.4, 0.4, 0.9],
  low: [0.3, 0.4, 0.8],
  high: [0.5, 0.6, 1.4],
  worst: 1.2,
  worst_frequency: 100,
  converging: 0.8,
};

const axis = {
  bandwidth: 150,
  prediction,
  laps: [lap(2e-6)],
  encoder: { amplitude: 40.12e-9, sine: 4e-8, cosine: 3e-9, period: 2e-5 },
  force: [0, 1],
  remains: [1e-7, -1e-7],
};

const result: Pick<Learning, 'axes' | 'time'> = { axes: { y: axis }, time: [0, 1] };

describe('the laps', () => {
  it('are curves of the measured and the true error, over a count of the encoder', () => {
    const { series, marks, x, y } = lapsChart(laps, 5e-8);
    expect(series.map(({ name, dash }) => [name, dash])).toEqual([
      ['x', 'solid'],
      ['x true', 'dash'],
      ['y', 'solid'],
      ['y true', 'dash'],
    ]);
    expect([series[0]?.x, series[0]?.y, series[3]?.y]).toEqual([
      [1, 2],
      [4e-6, 8e-7],
      [5e-7, 1e-7],
    ]);
    expect([x.log, y.log]).toEqual([undefined, true]);
    expect(marks.map(({ at }) => at)).toEqual([5e-8]);
    expect(lapsChart(laps, Number.NaN).marks).toEqual([]);
  });

  it('are rows from the first on, whose encoder comes with the result', () => {
    expect(lapRows(laps, null)).toEqual([
      { axis: 'x', first: '4.00', last: '0.800', truth: '0.200', encoder: '–' },
      { axis: 'y', first: '2.00', last: '0.400', truth: '0.100', encoder: '–' },
    ]);
    expect(lapRows({ y: [] }, result)).toEqual([
      { axis: 'y', first: '–', last: '–', truth: '–', encoder: '40.1' },
    ]);
  });
});

describe('the growth', () => {
  it('is that of motor and model, in front of the drawn ones', () => {
    const { series, bands, marks } = growthChart(result, 'y');
    expect(series.map(({ name, y }) => [name, y])).toEqual([
      ['motor', prediction.motor],
      ['model', prediction.model],
    ]);
    expect(bands[0]).toMatchObject({ low: prediction.low, high: prediction.high });
    expect(marks.map(({ axis, at }) => [axis, at])).toEqual([['y', 1]]);
  });

  it('has no band without drawn motors, and nothing of an axis that did not learn', () => {
    const alone = { ...axis, prediction: { ...prediction, low: null, high: null } };
    expect(growthChart({ axes: { y: alone } }, 'y').bands).toEqual([]);
    expect(growthChart(result, 'x').series).toEqual([]);
  });
});

it('draws force and error over the lap', () => {
  const [force, remains] = [overLap(result, 'force'), overLap(result, 'remains')];
  expect(force.series.map(({ name, y }) => [name, y])).toEqual([['y', [0, 1]]]);
  expect([force.y.unit, remains.y.unit]).toEqual(['N', 'm']);
  expect(remains.series[0]?.y).toEqual([1e-7, -1e-7]);
});

it('knows a refusal that learning anyway lifts', () => {
  const text = 'Learning would diverge: an error at 85 Hz would grow by 1.2 from lap to lap.';
  expect(diverges({ 'bandwidth.y': text, 'bandwidth.x': text })).toBe(true);
  expect(diverges({ 'bandwidth.y': text, laps: 'Is out of range.' })).toBe(false);
  expect(diverges({ 'bandwidth.y': 'Is out of range.' })).toBe(false);
  expect(diverges({})).toBe(false);
});

it('says what a learnt force is by its laps and their length', () => {
  const x = 'A'.repeat(32_000); // 6000 numbers of 4 bytes
  expect(knownText({ laps: 12, x }, 5e-4)).toBe('12 laps of 3.00 s');
  expect(knownText({ laps: 1, x: 'AAAAAAAAAAA=' }, 0)).toBe('1 lap');
});

it('forgets the force of every controller', () => {
  const scenario = { variants: { A: {}, B: {} } } as unknown as Scenario;
  expect(forgetting(scenario)).toEqual({
    learnt: null,
    'variants.A.controller.learnt': false,
    'variants.B.controller.learnt': false,
  });
});
