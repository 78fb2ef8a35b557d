/** The analytic force map of a scenario's plant, one phase, over the same axes as a computed map. */

import { numberAt } from '../../../app/api/scenario-paths';
import type { Scenario } from '../../../app/api/types';

const NAMES = ['tau', 'offset', 'F_pk', 'N_pk', 'I_pk', 'I_knee', 'h_2', 'h_3'] as const;

/** Parameters of the map, SI. */
export type Analytic = Record<(typeof NAMES)[number], number>;

/**
 * Returns the analytic map of a scenario's x axis: the plant's, or where that is a table the one
 * that a controller believes in; null where there is none.
 */
export function analyticOf(scenario: Scenario | null): (Analytic & { of: string }) | null {
  const letters = Object.keys(scenario?.variants ?? {});
  const places = [
    { of: 'plant', path: 'plant' },
    ...letters.map((of) => ({ of: `controller ${of}`, path: `variants.${of}.controller.model` })),
  ];
  for (const { of, path } of places) {
    const numbers = NAMES.map((name) => numberAt(scenario, `${path}.x.force_map.${name}`));
    if (!numbers.every(Number.isFinite)) continue;
    const map = Object.fromEntries(NAMES.map((name, k) => [name, numbers[k]]));
    return { ...(map as unknown as Analytic), of };
  }
  return null;
}

/** F(i)/F_pk, saturating. */
export function fraction({ I_pk, I_knee }: Analytic, i: number): number {
  const b = (I_pk / I_knee) ** 2;
  const q = (i / I_pk) ** 2;
  return ((1 + b) * q) / (1 + b * q);
}

/** Electrical angle, rad: pi at x = 0, where the teeth of a map without offset are aligned. */
const angle = ({ tau, offset }: Analytic, x: number) =>
  (2 * Math.PI * (x + offset)) / tau + Math.PI;

/** Thrust of one phase, N. */
export function thrust(map: Analytic, x: number, i: number): number {
  const theta = angle(map, x);
  const { h_2, h_3 } = map;
  const shape = Math.sin(theta) + h_2 * Math.sin(2 * theta) + h_3 * Math.sin(3 * theta);
  return (map.F_pk * fraction(map, i) * shape) / (1 - h_3);
}

/** Normal force of one phase, N. */
export function normalForce(map: Analytic, x: number, i: number): number {
  return 0.5 * map.N_pk * fraction(map, i) * (1 - Math.cos(angle(map, x)));
}

/** Largest thrust and normal force of one phase, N, at most at I_pk. */
export function peaks(map: Analytic, current: number): [number, number] {
  const [aligned, i] = [-map.offset, Math.min(current, map.I_pk)];
  return [thrust(map, aligned - map.tau / 4, i), normalForce(map, aligned, i)];
}
