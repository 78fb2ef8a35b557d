/** Curves over position from the tables of a force map, as the paper's Fig. 2. */

import type { MapTables, Scenario } from '../../../app/api/types';
import type { Ink } from '../../../plot/palette';
import type { Band, Dash, Series } from '../../../plot/types';
import { computed } from '../quantity-fields';
import { numberAt } from '../../../app/api/scenario-paths';

export type Force = 'thrust' | 'normal_force';

/** Currents from the largest down, told apart by colour and dashes; A and B keep theirs. */
const STYLES: readonly { ink: Ink; dash: Dash; width?: number }[] = [
  { ink: 'text', dash: 'solid', width: 2 },
  { ink: 'phase-a', dash: 'dash' },
  { ink: 'phase-c', dash: 'dashdot' },
  { ink: 'difference', dash: 'dot', width: 2 },
  { ink: 'phase-b', dash: 'solid', width: 1 },
];

const amperes = (i: number) => `${computed(i, '1').number} A`;

/** One curve for each of up to five currents, evenly from the largest down. */
export function curvesOf(map: MapTables, force: Force): Series[] {
  const last = map.currents.length - 1;
  const step = Math.max(1, Math.floor(last / STYLES.length));
  return STYLES.flatMap((style, k) => {
    const column = last - k * step;
    if (column <= 0) return [];
    return [
      {
        name: amperes(map.currents[column] ?? 0),
        x: map.positions,
        y: map[force].map((row) => row[column] ?? null),
        ...style,
      },
    ];
  });
}

/** How far the model is to be trusted, around the curve of the largest current. */
export function uncertaintyBand(map: MapTables, force: Force): Band {
  const share = map.uncertainty[force];
  const y = map[force].map((row) => row[row.length - 1] ?? Number.NaN);
  return {
    name: `±${computed(100 * share, '1').number} % at ${amperes(map.peaks.current)}`,
    x: map.positions,
    low: y.map((value) => value - Math.abs(value) * share),
    high: y.map((value) => value + Math.abs(value) * share),
    ink: 'reference',
  };
}

/** The paper's two peaks: the text names no positions, they stand at those of the map. */
export function publishedOf(map: MapTables, force: Force): Series[] {
  const at = force === 'thrust' ? map.peaks.peak_position : 0;
  return map.published.map((one, k) => ({
    name: `paper, ${k === 0 ? 'FEM' : 'measured'}`,
    x: [at],
    y: [one[force]],
    kind: 'points',
    marker: k === 0 ? 'diamond' : 'square',
    ink: 'text',
  }));
}

/** The plant's analytic map at the largest current of a computed one. */
export function analyticCurve(map: MapTables, analytic: Analytic, force: Force): Series {
  const of = force === 'thrust' ? thrust : normalForce;
  const i = Math.min(map.peaks.current, analytic.I_pk);
  return {
    name: `analytic, ${amperes(i)}`,
    x: map.positions,
    y: map.positions.map((x) => of(analytic, x, i)),
    ink: 'reference',
    dash: 'dash',
    width: 2,
  };
}

/** Rows of a heat map over position, one for each current. */
export function surface(map: MapTables, force: Force): number[][] {
  return map.currents.map((_, column) => map[force].map((row) => row[column] ?? Number.NaN));
}

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
