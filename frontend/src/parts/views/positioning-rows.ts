/** Accuracy and repeatability as curves and tables. */

import { looksOf } from '../../plot/palette';
import type { Series } from '../../plot/types';
import { digits, scaleFor } from '../../ui/units';
import type { Row } from './rows';
import type { DocumentOf } from './views-api';

type Positioning = DocumentOf<'positioning'>;

type Variant = Positioning['variants'][string];
type Figures = NonNullable<Variant['figures']>;
type Target = Variant['targets'][number];

/** Below this a deviation is nothing: a tenth of a nanometre. */
const LEAST = 1e-10;

/** Places of the first and the last target, m. */
export function ends(positioning: Positioning): number[] {
  const places = Object.values(positioning.variants).flatMap(({ targets }) =>
    targets.map(({ place }) => place),
  );
  return places.length === 0 ? [] : [Math.min(...places), Math.max(...places)];
}

/** Ends of the axis of targets, with room for their marks. */
export function room(positioning: Positioning): { from?: number; to?: number } {
  const [first, last] = ends(positioning);
  if (first === undefined || last === undefined) return {};
  const beside = 0.04 * (last - first) || 1e-3;
  return { from: first - beside, to: last + beside };
}

/** Mean and 2 s of each direction over the target: solid upwards, dashed downwards. */
export function deviationSeries(positioning: Positioning, names: readonly string[]): Series[] {
  return names.flatMap((name) => {
    const targets = positioning.variants[name]?.targets ?? [];
    if (targets.length === 0) return [];
    const x = targets.map(({ place }) => place);
    const one = (way: string, mean: (t: Target) => number, s: (t: Target) => number): Series => ({
      ...looksOf(name),
      name: `${name} ${way}`,
      x,
      y: targets.map(mean),
      error: targets.map((target) => 2 * s(target)),
    });
    return [
      {
        ...one(
          '↑',
          (t) => t.mean_up,
          (t) => t.s_up,
        ),
        marker: 'triangle',
      },
      {
        ...one(
          '↓',
          (t) => t.mean_down,
          (t) => t.s_down,
        ),
        marker: 'circle',
        dash: 'dash',
      },
    ];
  });
}

const FIGURES: readonly [string, string, (f: Figures) => number][] = [
  ['A', 'Accuracy: largest mean + 2 s less smallest mean − 2 s, both directions', (f) => f.A],
  ['A ↑', 'The same of approaches in the positive direction', (f) => f.A_up],
  ['A ↓', 'The same of approaches in the negative direction', (f) => f.A_down],
  ['E', 'Systematic deviation: range of the means of both directions', (f) => f.E],
  ['M', 'Range of the mean of both directions', (f) => f.M],
  ['R', 'Repeatability: largest 2 s↑ + 2 s↓ + |B| of a target, or 4 s', (f) => f.R],
  ['R ↑', 'Largest 4 s of approaches in the positive direction', (f) => f.R_up],
  ['R ↓', 'Largest 4 s of approaches in the negative direction', (f) => f.R_down],
  ['B', 'Reversal value: largest difference of both means at a target', (f) => f.B],
  ['mean B', 'Mean difference, positive less negative direction', (f) => f.B_mean],
];

export function figureRows(positioning: Positioning, names: readonly string[]): Row[] {
  return FIGURES.map(([name, title, of]) =>
    row(
      name,
      title,
      names.map((each) => {
        const figures = positioning.variants[each]?.figures ?? null;
        return figures && of(figures);
      }),
    ),
  );
}

/** Each target of a variant: a row of figures for each. */
export function targetRows(positioning: Positioning, name: string): Row[] {
  const targets = positioning.variants[name]?.targets ?? [];
  const of = (title: string, value: (target: Target) => number) =>
    [title, targets.map(value)] as const;
  const columns = {
    'mean ↑': of('Mean deviation, positive direction', (t) => t.mean_up),
    'mean ↓': of('Mean deviation, negative direction', (t) => t.mean_down),
    's ↑': of('Standard deviation, positive direction', (t) => t.s_up),
    's ↓': of('Standard deviation, negative direction', (t) => t.s_down),
    B: of('Reversal value of the target', (t) => t.reversal),
  };
  return Object.entries(columns).map(([own, [title, values]]) => row(own, title, values));
}

function row(name: string, title: string, values: readonly (number | null)[]): Row {
  const known = values.filter((value) => value !== null).map(Math.abs);
  const scale = scaleFor(Math.max(1e-9, ...known), 'm');
  const text = (value: number | null) => {
    if (value === null) return '–';
    return Math.abs(value) < LEAST ? '0' : digits(value * scale.factor);
  };
  return { name, title, unit: scale.unit, cells: values.map(text) };
}
