/** The circular test as curves and tables. */

import { AxisScale } from '../../plot/axis-scale';
import type { CurveData } from '../../plot/plot-menu';
import type { PolarCurve } from '../../plot/polar';
import { looksOf } from '../../plot/palette';
import { row, type Row } from './rows';
import type { DocumentOf } from './views-api';

type Ballbar = DocumentOf<'ballbar'>;

export type Shown = 'both' | 'ccw' | 'cw';

type Direction = Ballbar['variants'][string]['directions'][string];
type Both = NonNullable<Ballbar['variants'][string]['both']>;

export interface Head {
  variant: string;
  way: string;
  simulated: boolean;
}

/** Curves of the directions that are shown: solid counter-clockwise, dashed clockwise. */
export function polarCurves(
  ballbar: Ballbar,
  names: readonly string[],
  shown: Shown,
): PolarCurve[] {
  return names.flatMap((name) =>
    Object.entries(ballbar.variants[name]?.directions ?? {})
      .filter(([way]) => shown === 'both' || shown === way)
      .map(([way, { deviation }]) => ({
        ...looksOf(name),
        name: `${name} ${way}`,
        values: deviation,
        dash: way === 'cw' ? ('dash' as const) : ('solid' as const),
      })),
  );
}

const ANGLE = { label: 'angle', unit: '°', scale: { factor: 1, unit: '°' } };
const DEVIATION = { label: 'radial deviation', unit: 'm' };

/** The curves over the angle, as a table has them. */
export function polarData(curves: readonly PolarCurve[]): CurveData {
  const all = curves.flatMap(({ values }) => values);
  const [low, high] = [Math.min(0, ...all), Math.max(0, ...all)];
  return {
    series: curves.map(({ name, values }) => ({
      name,
      x: values.map((_, i) => (360 * (i + 0.5)) / values.length),
      y: values,
    })),
    bands: [],
    x: new AxisScale(ANGLE, 0, 360, [0, 360]),
    y: new AxisScale(DEVIATION, low, high, [0, 1]),
  };
}

export function heads(ballbar: Ballbar, names: readonly string[]): Head[] {
  return names.flatMap((variant) =>
    Object.entries(ballbar.variants[variant]?.directions ?? {}).map(([way, { simulated }]) => ({
      variant,
      way,
      simulated,
    })),
  );
}

const AT = ['0°', '90°', '180°', '270°'];

const ONE: readonly [string, string, (one: Direction) => number | null][] = [
  [
    'G',
    'Circular deviation: largest less least distance from the least-squares centre',
    (o) => o.G,
  ],
  ['F max', 'Largest radial deviation about the programmed centre', (o) => o.F_max],
  ['F min', 'Least radial deviation about the programmed centre', (o) => o.F_min],
  ...AT.map((at, k): [string, string, (one: Direction) => number | null] => [
    `radial step ${at}`,
    'Change of the radial deviation where an axis reverses, outwards positive. The quadrant glitch of Reversals is of the error of one axis',
    (o) => o.quadrants[k] ?? null,
  ]),
];

const BOTH: readonly [string, string, string, (both: Both) => number][] = [
  ['G(b)', 'Circular deviation of both directions about one centre', 'm', (b) => b.G],
  ['H', 'Largest difference between both directions', 'm', (b) => b.H],
  ['mean radius', 'Mean radius less that of the reference', 'm', (b) => b.radius_error],
  ['centre x', 'Centre less that of the reference', 'm', (b) => b.offset_x],
  ['centre y', 'Centre less that of the reference', 'm', (b) => b.offset_y],
  ['squareness', 'A right angle less that between the axes', 'rad', (b) => b.squareness],
  ['scale x − y', 'Scale of x less that of y', '1', (b) => b.scale_mismatch],
  ['x lags y by', 'From what differs between both directions', 's', (b) => b.servo_mismatch],
];

export function directionRows(ballbar: Ballbar, names: readonly string[]): Row[] {
  const ones = names.flatMap((name) => Object.values(ballbar.variants[name]?.directions ?? {}));
  return ONE.map(([name, title, of]) => row(name, title, 'm', ones.map(of)));
}

export function bothRows(ballbar: Ballbar, names: readonly string[]): Row[] {
  const boths = names.map((name) => ballbar.variants[name]?.both ?? null);
  if (boths.every((both) => both === null)) return [];
  return BOTH.map(([name, title, unit, of]) =>
    row(
      name,
      title,
      unit,
      boths.map((both) => both && of(both)),
    ),
  );
}
