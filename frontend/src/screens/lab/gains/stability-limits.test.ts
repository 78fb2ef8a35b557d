import { expect, it } from 'vitest';
import type { Loops } from '../../../app/api/types';
import { read } from './stability-limits.svelte';

const loop = {
  velocity: 0.17,
  stable: true,
  k_p_limit: 3.3e6,
  k_d_limit: null,
  crossover: 46,
  phase_margin: 0.97,
  gain_margin: 10,
  gain_reduction: null,
  Ms: 1.2,
  bandwidth: 73,
};

it('reads the limits that there are', () => {
  const answer: Loops = {
    variants: { A: { axes: { x: loop }, note: null }, B: { axes: {}, note: 'no linearisation' } },
  };
  expect(read(answer)).toEqual({ 'variants.A.controller.x.k_p': 3.3e6 });
});
