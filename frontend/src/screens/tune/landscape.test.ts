import { expect, it } from 'vitest';
import { costAt, edgeLine, pathLine } from './landscape';
import type { LoopFigures } from '../../parts/loop/loops.svelte';
import { limitWarnings } from './loop-figures';

const MAP = {
  stride: 1,
  k_p: [1e4, 1e5, 1e6],
  k_d: [1e2, 1e3],
  cost: [
    [1, 2, 3],
    [4, 5, null],
  ],
  edge: [
    [
      [1e4, 500],
      [2e4, 600],
    ],
    [[5e5, 200]],
  ] as [number, number][][],
  present: [2e5, 1e3] as [number, number],
  paper: [2e5, 1e3] as [number, number],
};

it('draws the edge as one line with gaps between its pieces', () => {
  const [line] = edgeLine(MAP);
  expect(line?.x).toEqual([1e4, 2e4, null, 5e5, null]);
  expect(line?.y).toEqual([500, 600, null, 200, null]);
  expect(edgeLine({ ...MAP, edge: [] })).toEqual([]);
});

it('reads the cost of the nearest gains, evenly in logarithms', () => {
  expect(costAt(MAP, [3e4, 120])).toBe(1);
  expect(costAt(MAP, [4e4, 900])).toBe(5);
  expect(costAt(MAP, [9e5, 900])).toBeNull();
});

it('draws the way of a start only of the axis that is shown', () => {
  const start = { gains: { 'x.k_p': [1, 2], 'x.k_d': [3, 4] }, cost: [1, 1] };
  expect(pathLine(start, 'x')).toHaveLength(1);
  expect(pathLine(start, 'y')).toEqual([]);
});

it('names the edge of gains that are unstable', () => {
  const standstill = { velocity: 0, stable: true };
  const figures = {
    velocity: 0.17,
    stable: false,
    k_p_limit: 3.254e6,
    k_d_limit: null,
    standstill,
  } as LoopFigures;
  expect(limitWarnings(figures, 'x')).toEqual([
    'The chosen gains of x are unstable. The stability boundary, each gain moved alone: k_p = 3254 N/mm.',
  ]);
  const stable = { ...figures, stable: true };
  expect(limitWarnings(stable, 'x')).toEqual([]);
  const stuck = { ...figures.standstill, stable: false, k_p_limit: null, k_d_limit: null };
  expect(limitWarnings({ ...stable, standstill: stuck }, 'x')).toEqual([
    'The chosen gains of x are unstable at standstill.',
  ]);
});
