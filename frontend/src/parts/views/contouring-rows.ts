/** Contour and tracking error as curves and tables. */

import type { PlotAxis, Series } from '../../plot/types';
import { looksOf } from '../../plot/palette';
import { digits } from '../../ui/units';
import { row, type Row } from './rows';
import type { DocumentOf } from './views-api';

type Contouring = DocumentOf<'contouring'>;

type Figures = NonNullable<Contouring['variants'][string]>['figures'];

/** Share of the path's size that the largest contour error is drawn as. */
const SHARE = 0.1;

const FIGURES: readonly [keyof Figures, string, string, string][] = [
  ['contour_max', 'contour max', 'Largest distance from the path', 'm'],
  ['contour_rms', 'contour RMS', 'Of the distance from the path, over time', 'm'],
  ['tracking_max', 'tracking max', 'Largest length of the following error', 'm'],
  ['tracking_rms', 'tracking RMS', 'Of the length of the following error, over time', 'm'],
  ['along_max', 'along max', 'Largest following error along the path', 'm'],
  ['along_rms', 'along RMS', 'Of the following error along the path', 'm'],
  ['across_max', 'across max', 'Largest following error across the path', 'm'],
  ['across_rms', 'across RMS', 'Of the following error across the path', 'm'],
  ['lag_distance', 'mean lag', 'Along the path to the nearest point, while it moves', 'm'],
  ['lag_time', 'late by', 'Mean lag over mean speed', 's'],
];

export const AXIS_OF: Readonly<Record<'arc' | 'time', PlotAxis>> = {
  arc: { label: 'arc length', unit: 'm' },
  time: { label: 'time', unit: 's' },
};

export function figureRows(contouring: Contouring, names: readonly string[]): Row[] {
  return FIGURES.map(([key, name, title, unit]) =>
    row(
      name,
      title,
      unit,
      names.map((variant) => contouring.variants[variant]?.figures[key] ?? null),
    ),
  );
}

export const PEAK_HEADS = ['contour µm', 'arc mm', 'x mm', 'y mm', 'time s'].map((name) => ({
  name,
}));

export function peakRows(contouring: Contouring, names: readonly string[]): Row[] {
  return names.flatMap((variant) =>
    (contouring.variants[variant]?.peaks ?? []).map(({ contour, arc, x, y, time }, k) => ({
      name: `${variant} ${k + 1}`,
      title: 'A peak of the contour error, and where the reference is then',
      unit: '',
      cells: [
        digits(1e6 * contour),
        digits(1e3 * arc, 4),
        digits(1e3 * x),
        digits(1e3 * y),
        digits(time, 4),
      ],
    })),
  );
}

/** An error over arc length or time, of each variant. */
export function errorSeries(
  contouring: Contouring,
  names: readonly string[],
  error: 'contour' | 'tracking',
  over: 'arc' | 'time',
): Series[] {
  return names.flatMap((name) => {
    const points = contouring.variants[name]?.points;
    return points ? [{ name, x: points[over], y: points[error], ...lookOf(name) }] : [];
  });
}

/** By how much the contour error is magnified: 1, 2 or 5 times a power of ten. */
export function magnification(contouring: Contouring, names: readonly string[]): number {
  const largest = Math.max(
    0,
    ...names.map((name) => contouring.variants[name]?.figures.contour_max ?? 0),
  );
  if (largest === 0) return 1;
  const factor = (SHARE * Math.max(extent(contouring.path_x), extent(contouring.path_y))) / largest;
  const power = 10 ** Math.floor(Math.log10(factor));
  return Math.max(1, power * ([5, 2, 1].find((step) => step * power <= factor) ?? 1));
}

/** The path, and off it each variant with its contour error magnified. */
export function planeSeries(
  contouring: Contouring,
  names: readonly string[],
  factor: number,
): Series[] {
  const path: Series = {
    name: 'path',
    x: contouring.path_x,
    y: contouring.path_y,
    ink: 'reference',
  };
  return [
    path,
    ...names.flatMap((name) => {
      const points = contouring.variants[name]?.points;
      if (!points) return [];
      const x = points.x.map((at, i) => at + factor * (points.off_x[i] ?? 0));
      const y = points.y.map((at, i) => at + factor * (points.off_y[i] ?? 0));
      return [{ name, x, y, ...lookOf(name) }];
    }),
  ];
}

/** Markers at every sample would hide the curve: B is the thicker line. */
const lookOf = (name: string) => ({
  ink: looksOf(name).ink ?? 'a',
  width: name === 'A' ? 1.2 : 2.4,
});

function extent(values: readonly number[]): number {
  return values.reduce((a, b) => Math.max(a, b)) - values.reduce((a, b) => Math.min(a, b));
}
