import { describe, expect, it } from 'vitest';
import { matchingOptions } from '../../../ui/finder';
import { exampleOf, grouped } from './examples';

const circle = exampleOf({
  name: 'circle',
  title: "The paper's circle",
  description: 'Circle of 15 mm at 1/3 Hz. A: PD alone;\nB: the same. More.',
});
const stair = exampleOf({
  name: 'stair-x-500nm',
  title: 'Table 1: staircase of 0.5 um on x',
  description: 'Table 1: 0.5 um steps on x (the paper gives none for y). A: PD alone.',
});

describe('an example', () => {
  it('has a title, and what it shows in a sentence or two', () => {
    expect(circle.name).toBe("The paper's circle");
    expect(circle.detail).toBe('Circle of 15 mm at 1/3 Hz. A: PD alone; B: the same.');
    expect(stair.name).toBe('Staircase of 0.5 µm on x');
    expect(stair.detail).toBe('0.5 µm steps on x (the paper gives none for y).');
  });

  it('is in the group of its table', () => {
    const groups = grouped([circle, stair]).map(([group, all]) => [group, all.length]);
    expect(groups).toEqual([
      ['The circle', 1],
      ['Table 1 of the paper', 1],
    ]);
  });

  it('is found by its name in files too', () => {
    expect(matchingOptions([circle, stair], 'stair-x')).toEqual([stair]);
    expect(matchingOptions([circle, stair], 'PD alone')).toHaveLength(2);
  });
});
