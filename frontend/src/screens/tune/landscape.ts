/** What the heat map of a gain landscape is given. */

import type { AxisLandscape, TuneHistory, Axis } from '../../app/api/types';
import { contour } from '../../plot/heat-grid';
import type { Layer, Line as MapLine, Region, Spot } from '../../plot/types';
import { digits } from '../../ui/units';
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

/** What a search can limit, in the unit that it is shown in. */
const LIMITED = [
  { name: 'gain_margin', label: 'GM', unit: 'dB', shown: (x: number) => 20 * Math.log10(x) },
  { name: 'phase_margin', label: 'PM', unit: '°', shown: (x: number) => (x * 180) / Math.PI },
  { name: 'Ms', label: 'M_s', unit: '', shown: (x: number) => x },
  { name: 'saturated', label: 'saturated', unit: '%', shown: (x: number) => 100 * x },
  { name: 'force', label: 'thrust', unit: 'N', shown: (x: number) => x },
] as const;

/** Of each margin: levels that are drawn beside its limit, how it looks, and what instability is. */
const CONTOURS = {
  gain_margin: { levels: [3, 12], ink: 'phase-b', dash: 'dash', unstable: 0 },
  phase_margin: { levels: [15, 45], ink: 'phase-c', dash: 'solid', unstable: 0 },
  Ms: { levels: [1.5, 2.5], ink: 'difference', dash: 'dot', unstable: Infinity },
} as const;

type Limits = Readonly<Record<string, number | null>>;

/** The families of lines, and the region, that the legend switches. */
export const OUTSIDE = 'beyond a limit';
export const FAMILIES = ['GM', 'PM', 'M_s', OUTSIDE] as const;

/** Margins, saturation and thrust of each cell, as its cost is. */
export function layersOf({ limits = {} }: AxisLandscape): Layer[] {
  return LIMITED.flatMap(({ name, label, unit, shown }) => {
    const rows = limits[name];
    if (!rows) return [];
    const of = (value: number | null) => (value === null ? null : shown(value));
    // The figures of the loop are at one speed; these are the worst of several.
    const named = name in CONTOURS ? `${label}, worst case` : label;
    return [{ label: named, unit, rows: rows.map((row) => row.map(of)) }];
  });
}

/** Lines of equal margin: the limit bold and with its sign, further levels thin. */
export function marginLines({ k_p, k_d, limits: maps = {} }: AxisLandscape, limits: Limits) {
  return LIMITED.flatMap(({ name, label, unit, shown }): MapLine[] => {
    const [map, look] = [maps[name], name in CONTOURS && CONTOURS[name as keyof typeof CONTOURS]];
    if (!map || !look) return [];
    const rows = map.map((row) => row.map((at) => (at === null ? look.unstable : shown(at))));
    const limit = limits[name] ?? null;
    const at = limit === null ? null : Number(shown(limit).toPrecision(3));
    const others = look.levels.filter((level) => at === null || Math.abs(level / at - 1) > 0.05);
    return [...(at === null ? [] : [at]), ...others].flatMap((level) => {
      const { x, y } = contour(k_p, k_d, rows, level);
      if (x.length === 0) return [];
      const sign = level !== at ? ' ' : name === 'Ms' ? ' ≤ ' : ' ≥ ';
      const text = `${label.replace('_', '')}${sign}${digits(level)}${unit === 'dB' ? ' dB' : unit}`;
      const { ink, dash } = look;
      const width = level === at ? 2.6 : 1.2;
      return [{ name: text, label: text, family: label, x, y, ink, dash, width }];
    });
  });
}

/** The cells that a search would refuse: one of the limits does not hold there. */
export function outside({ cost, limits: maps = {} }: AxisLandscape, limits: Limits): Region | null {
  const tests = LIMITED.flatMap(({ name }) => {
    const [map, limit] = [maps[name], limits[name] ?? null];
    if (!map) return [];
    const least = name === 'gain_margin' || name === 'phase_margin';
    return [
      (j: number, i: number) => {
        const value = map[j]?.[i] ?? null;
        // An unstable loop is refused without any limit.
        if (value === null) return true;
        return limit !== null && (least ? value < limit : value > limit);
      },
    ];
  });
  if (tests.length === 0) return null;
  return {
    name: OUTSIDE,
    rows: cost.map((row, j) => row.map((_, i) => tests.some((fails) => fails(j, i)))),
  };
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
      ...(own ?? { ink: 'staged', marker: 'circle', family: 'found' }),
    };
    return id === chosen ? { ...spot, label: name } : spot;
  });
}

/** Returns the cost of the cell that lies nearest to a pair of gains. */
export function costAt({ k_p, k_d, cost }: AxisLandscape, at: [number, number]): number | null {
  const nearest = (values: readonly number[], target: number) =>
    values.reduce(
      (best, value, i) =>
        Math.abs(Math.log(value / target)) < Math.abs(Math.log((values[best] ?? value) / target))
          ? i
          : best,
      0,
    );
  return cost[nearest(k_d, at[1])]?.[nearest(k_p, at[0])] ?? null;
}
