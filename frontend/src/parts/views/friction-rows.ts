/** Friction anatomy as curves and tables. */

import type { Cursor, Mark, PlotAxis, Series } from '../../plot/types';
import { digits, PER_MM, quantity, scaleFor, type Scale } from '../../ui/units';
import type { Row } from './rows';
import type { DocumentOf } from './views-api';

type FrictionAnatomy = DocumentOf<'friction'>;

export type FrictionAxis = FrictionAnatomy['axes'][string];
export type Curves = NonNullable<FrictionAxis['variants'][string]['curves']>;
type Figures = NonNullable<FrictionAxis['variants'][string]['figures']>;
type Parameters = NonNullable<FrictionAxis['motor']>;
type Numbers = readonly (number | null)[];

/** What is drawn over the displacement: where the axis is, or how far it went since it turned. */
export type Way = 'loop' | 'presliding';

export interface Plotted {
  title: string;
  x: PlotAxis;
  y: PlotAxis;
  series: Series[];
  marks: Mark[];
  /** Whether it is over time, in which each point has a place of its own. */
  timed?: boolean;
}

const FORCE = { label: 'friction', unit: 'N' };

/** True, estimated and compensated friction over some abscissa; `at` is the point that is marked. */
function forces(curves: Curves, x: Numbers, at: number, sign?: readonly number[]): Series[] {
  const along = (values: readonly number[]) =>
    sign ? values.map((value, i) => value * (sign[i] ?? 0)) : values;
  const own: Series[] = [
    { name: 'true', x, y: along(curves.friction), ink: 'phase-b', width: 2, at },
    { name: 'estimate', x, y: along(curves.estimate), ink: 'phase-a', dash: 'dash', at },
  ];
  if (curves.compensation) {
    const y = along(curves.compensation);
    own.push({ name: 'compensation', x, y, ink: 'text', dash: 'dot', at });
  }
  return own;
}

export function overVelocity(axis: FrictionAxis, variant: string, at: number): Plotted | null {
  const own = axis.variants[variant];
  if (!own?.curves) return null;
  const curve = { x: axis.velocities };
  return {
    title: 'Over velocity',
    x: { label: 'velocity', unit: 'm/s' },
    y: FORCE,
    series: [
      ...(axis.stribeck
        ? [
            {
              ...curve,
              name: 'Stribeck, motor',
              y: axis.stribeck,
              ink: 'reference',
              width: 4,
            } as const,
          ]
        : []),
      ...(own.stribeck
        ? [
            {
              ...curve,
              name: 'Stribeck, model',
              y: own.stribeck,
              ink: 'muted',
              dash: 'long',
            } as const,
          ]
        : []),
      ...forces(own.curves, own.curves.velocity, at),
    ],
    marks: axis.motor ? [{ axis: 'x', at: axis.motor.v_s, label: 'vₛ' }] : [],
  };
}

export function overDisplacement(
  axis: FrictionAxis,
  variant: string,
  way: Way,
  at: number,
): Plotted | null {
  const own = axis.variants[variant];
  if (!own?.curves) return null;
  if (way === 'loop') {
    return {
      title: 'Over position',
      x: { label: 'position', unit: 'm' },
      y: FORCE,
      series: forces(own.curves, own.curves.position, at),
      marks: [],
    };
  }
  const breakaway = own.figures?.breakaway ?? null;
  return {
    title: 'After reversals',
    x: { label: 'displacement since the turn', unit: 'm' },
    y: FORCE,
    series: forces(own.curves, presliding(axis, own.curves), at, axis.direction),
    marks:
      breakaway === null
        ? []
        : [{ axis: 'y', at: breakaway, label: `breakaway ${quantityText(breakaway, 'N')}` }],
  };
}

/** Displacement while it is presliding; a gap elsewhere, and between two reversals. */
function presliding(axis: FrictionAxis, { displacement }: Curves): (number | null)[] {
  return displacement.map((away, i) => {
    const turned = axis.direction[i] !== axis.direction[i + 1];
    return away === null || away > axis.presliding || turned ? null : away;
  });
}

export function overTime(axis: FrictionAxis, variant: string, at: number): Plotted | null {
  const curves = axis.variants[variant]?.curves;
  if (!curves) return null;
  const x = axis.time;
  return {
    title: 'Bristle over time',
    x: { label: 'time', unit: 's', scale: { factor: 1, unit: 's' } },
    y: { label: 'deflection', unit: 'm' },
    series: [
      { name: 'true', x, y: curves.bristle, ink: 'phase-b', width: 2, at },
      { name: 'estimate', x, y: curves.bristle_estimate, ink: 'phase-a', dash: 'dash', at },
    ],
    marks: [],
    timed: true,
  };
}

/** The marked point nearest to a cursor: over time along it, else in the plane of the curves. */
export function pointAt({ series, timed = false }: Plotted, { x, y }: Cursor): number {
  const marked = series.filter(({ at }) => at !== undefined);
  const [wide, high] = [range(marked.map((one) => one.x)), range(marked.map((one) => one.y))];
  let [best, nearest] = [Number.POSITIVE_INFINITY, 0];
  for (const one of marked) {
    for (let i = 0; i < one.x.length; i++) {
      const [px, py] = [one.x[i], one.y[i]];
      if (px === null || px === undefined || py === null || py === undefined) continue;
      const across = timed || y === null ? 0 : (py - y) / high;
      const away = ((px - x) / wide) ** 2 + across ** 2;
      if (away < best) [best, nearest] = [away, i];
    }
  }
  return nearest;
}

function range(all: readonly ArrayLike<number | null>[]): number {
  let [low, high] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
  for (const values of all) {
    for (let i = 0; i < values.length; i++) {
      const value = values[i];
      if (value === null || value === undefined) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  return high > low ? high - low : 1;
}

/** One legend for all plots, with what each force is at the marked point. */
export function legend(plots: readonly Plotted[], at: number): { look: Series; value: string }[] {
  return (plots[0]?.series ?? []).map((look) => ({
    look,
    value: look.at === undefined ? '' : `${digits(look.y[at] ?? Number.NaN)} N`,
  }));
}

/** What else is read at the marked point. */
export function readings(curves: Curves, at: number): Row[] {
  const all: [string, string, Numbers, string][] = [
    ['velocity', 'True velocity', curves.velocity, 'm/s'],
    ['position', 'True position', curves.position, 'm'],
    ['since the turn', 'Displacement since the last reversal', curves.displacement, 'm'],
    ['bristle z', 'Bristle state of the motor', curves.bristle, 'm'],
    ['estimate z*', 'Bristle state of the observer', curves.bristle_estimate, 'm'],
  ];
  return all.map(([name, title, values, unit]) => {
    const { number, unit: shown } = quantity(values[at] ?? null, unit);
    return { name, title, unit: shown, cells: [number] };
  });
}

type Of<T> = (of: T) => number | null;

const FIGURES: readonly [string, string, Scale | string, Of<Figures>][] = [
  ['mismatch RMS', 'Estimated less true friction, RMS', 'N', (f) => f.mismatch_rms],
  ['mismatch max', 'Estimated less true friction, largest', 'N', (f) => f.mismatch_max],
  [
    'compensated',
    'Share of the RMS of friction that the compensation takes away',
    { factor: 100, unit: '%' },
    (f) => f.compensated,
  ],
  ['breakaway', 'Largest friction after a reversal, median', 'N', (f) => f.breakaway],
  ['breakaway, estimate', 'The same of the estimate', 'N', (f) => f.breakaway_estimate],
  [
    'loop stiffness',
    'Slope of friction over displacement about zero after a reversal, median; σ₀ if slow',
    PER_MM.stiffness,
    (f) => f.stiffness,
  ],
  [
    'loop stiffness, estimate',
    'The same of the estimate',
    PER_MM.stiffness,
    (f) => f.stiffness_estimate,
  ],
];

export function figureRows(axis: FrictionAxis, names: readonly string[]): Row[] {
  return FIGURES.map(([name, title, unit, of]) =>
    row(
      name,
      title,
      unit,
      names.map((each) => {
        const figures = axis.variants[each]?.figures ?? null;
        return figures && of(figures);
      }),
    ),
  );
}

const PARAMETERS: readonly [string, string, Scale | string, Of<Parameters>][] = [
  ['F_s', 'Stiction', 'N', (p) => p.F_s],
  ['F_c', 'Coulomb friction', 'N', (p) => p.F_c],
  ['v_s', 'Stribeck velocity', 'm/s', (p) => p.v_s],
  ['sigma_0', 'Bristle stiffness', PER_MM.stiffness, (p) => p.sigma_0],
  ['sigma_1', 'Bristle damping', PER_MM.damping, (p) => p.sigma_1],
  ['sigma_2', 'Viscous friction', { factor: 1, unit: 'N s/m' }, (p) => p.sigma_2],
];

/** Parameters of the motor, then of the model of each variant. */
export function parameterRows(axis: FrictionAxis, names: readonly string[]): Row[] {
  const all = [axis.motor, ...names.map((name) => axis.variants[name]?.model ?? null)];
  return PARAMETERS.map(([name, title, unit, of]) =>
    row(
      name,
      title,
      unit,
      all.map((each) => each && of(each)),
    ),
  );
}

function row(name: string, title: string, unit: Scale | string, values: (number | null)[]): Row {
  const known = values.filter((value) => value !== null).map(Math.abs);
  const scale = typeof unit === 'string' ? scaleFor(Math.max(0, ...known), unit) : unit;
  const cells = values.map((value) => (value === null ? '–' : digits(value * scale.factor)));
  return { name, title, unit: scale.unit, cells };
}

function quantityText(value: number, unit: string): string {
  const shown = quantity(value, unit);
  return `${shown.number} ${shown.unit}`;
}
