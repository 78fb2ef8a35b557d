/** Curves over position from the tables of a force map, as the paper's Fig. 2. */

import type { MapTables } from '../../../app/api/types';
import type { Ink } from '../../../plot/palette';
import type { Band, Dash, Series } from '../../../plot/types';
import { computed } from '../quantity-fields';
import { normalForce, thrust, type Analytic } from './analytic-map';

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
export function trustOf(map: MapTables, force: Force): Band {
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
