/** What the heat map of a gain landscape is given. */

import type { AxisLandscape, TuneHistory, Axis } from '../../app/api/types';
import type { Line as MapLine, Spot } from '../../plot/types';
import type { CandidateLine } from './candidates';

/** The stability boundary: one line, with a gap between its pieces. */
export function edgeLine({ edge }: AxisLandscape): MapLine[] {
  const gap: [null, null] = [null, null];
  const places = edge.flatMap((piece) => [...piece, gap]);
  if (places.length === 0) return [];
  return [
    {
      name: 'stability boundary',
      x: places.map(([k_p]) => k_p),
      y: places.map(([, k_d]) => k_d),
      ink: 'bad',
      dash: 'dash',
      width: 2,
    },
  ];
}

/** The way of the best start over the map. */
export function pathLine(start: TuneHistory | undefined, axis: Axis): MapLine[] {
  const x = start?.gains[`${axis}.k_p`];
  const y = start?.gains[`${axis}.k_d`];
  if (!x || !y || x.length < 2) return [];
  return [{ name: 'simplex', x, y, ink: 'text', dash: 'dot', width: 1 }];
}

const MARKERS = {
  present: { ink: 'text', marker: 'square' },
  paper: { ink: 'muted', marker: 'diamond' },
  picked: { ink: 'focus', marker: 'cross' },
} as const;

/** Sets of gains as points; those that start from the present ones coincide with them. */
export function spotsOf(lines: readonly CandidateLine[], chosen: string): Spot[] {
  return lines.map(({ id, name, k_p, k_d }) => {
    const own = id in MARKERS ? MARKERS[id as keyof typeof MARKERS] : null;
    const spot: Spot = {
      name,
      x: k_p,
      y: k_d,
      ...(own ?? { ink: 'staged', marker: 'circle', family: 'found from each start' }),
    };
    return id === chosen ? { ...spot, label: name } : spot;
  });
}

/** Returns the cost of the cell that lies nearest to a pair of gains. */
export function costAt({ k_p, k_d, cost }: AxisLandscape, at: [number, number]): number | null {
  const nearest = (values: readonly number[], wanted: number) =>
    values.reduce(
      (best, value, i) =>
        Math.abs(Math.log(value / wanted)) < Math.abs(Math.log((values[best] ?? value) / wanted))
          ? i
          : best,
      0,
    );
  return cost[nearest(k_d, at[1])]?.[nearest(k_p, at[0])] ?? null;
}
