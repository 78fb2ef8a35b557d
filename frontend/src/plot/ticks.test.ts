import { describe, expect, it } from 'vitest';
import { timeSplits, valueSplits, valueTexts } from './ticks';

describe('valueSplits', () => {
  it('are round and no nearer than a line of text', () =>
    expect(valueSplits({ from: -30e-6, to: 40e-6 }, 100)).toEqual([-20e-6, 0, 20e-6, 40e-6]));
  it('are both ends and zero where there is little room', () => {
    expect(valueSplits({ from: -3, to: 4 }, 40)).toEqual([-3, 0, 4]);
    expect(valueSplits({ from: -1, to: 4 }, 40)).toEqual([-1, 4]);
  });
});

describe('valueTexts', () => {
  it('have the unit at the last', () =>
    expect(valueTexts([-20e-6, 0, 20e-6], 'm')).toEqual(['−20', '0', '20 µm']));
  it('keep the half that tells neighbours apart', () =>
    expect(valueTexts([0, 2.5, 5], 'A')).toEqual(['0', '2.5', '5 A']));
});

describe('timeSplits', () => {
  it('are round and apart, also where the window is between them', () =>
    expect(timeSplits({ from: 1.3, to: 11.3 }, 600)).toEqual([2, 4, 6, 8, 10]));
});
