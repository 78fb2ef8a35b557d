/** Results of learning for display: laps, growth of an error, force and what remains. */

import { LEARNT } from '../../../app/api/scenario-paths';
import {
  AXES,
  type Axis,
  type Changes,
  type Learning,
  type LearnLap,
  type LearntForce,
  type Scenario,
} from '../../../app/api/types';
import type { Ink } from '../../../plot/palette';
import type { Band, Dash, Mark, PlotAxis, Series } from '../../../plot/types';
import { show } from '../../../app/fields/fields.svelte';
import { digits } from '../../../ui/units';

export type Laps = Readonly<Record<string, readonly LearnLap[]>>;

export const PICTURES = ['laps', 'growth', 'force', 'remains'] as const;
export type Picture = (typeof PICTURES)[number];

/** What a plot is given. */
export interface Chart {
  title: string;
  x: PlotAxis;
  y: PlotAxis;
  series: Series[];
  bands: Band[];
  marks: Mark[];
}

const BYTES = 4;
const INKS: Readonly<Record<Axis, Ink>> = { x: 'phase-a', y: 'phase-c' };

/** Measured and true largest error of each lap. */
export function lapsChart(laps: Laps, count: number): Chart {
  const series = axesOf(laps).flatMap((axis): Series[] => {
    const own = laps[axis] ?? [];
    const x = own.map((_, i) => i + 1);
    const of = (name: string, key: 'peak' | 'true_peak', dash: Dash): Series => ({
      name: `${axis}${name}`,
      x,
      y: own.map((lap) => lap[key]),
      ink: INKS[axis],
      dash,
    });
    return [of('', 'peak', 'solid'), of(' true', 'true_peak', 'dash')];
  });
  const marks: Mark[] = Number.isFinite(count)
    ? [{ axis: 'y', at: count, label: 'one count', ink: 'muted', dash: 'dot' }]
    : [];
  const y = { label: 'max |e|', unit: 'm', scale: MICROMETRES, log: true };
  return { title: 'Laps', x: { label: 'lap' }, y, series, bands: [], marks };
}

/** The factor of an error that repeats, of one axis. */
export function growthChart({ axes }: Pick<Learning, 'axes'>, axis: Axis): Chart {
  const title = `Growth on ${axis}`;
  const [x, y] = [
    { label: 'frequency', unit: 'Hz', log: true },
    { label: 'ρ from lap to lap', from: 0 },
  ];
  const learnt = axes[axis];
  if (!learnt) return { title, x, y, series: [], bands: [], marks: [] };
  const { frequency, motor, model, low, high } = learnt.prediction;
  const series: Series[] = [
    { name: 'motor', x: frequency, y: motor, ink: INKS[axis] },
    { name: 'model', x: frequency, y: model, ink: 'text', dash: 'dash' },
  ];
  const bands: Band[] =
    low && high ? [{ name: '5–95 % drawn', x: frequency, low, high, ink: 'muted' }] : [];
  const marks: Mark[] = [{ axis: 'y', at: 1, label: 'grows above', ink: 'bad', dash: 'dot' }];
  return { title, x, y, series, bands, marks };
}

/** The learnt force, or the following error that remains, over the lap. */
export function overLap(
  { axes, time }: Pick<Learning, 'axes' | 'time'>,
  key: 'force' | 'remains',
): Chart {
  const series = axesOf(axes).map((axis): Series => {
    const dash = axis === 'x' ? 'solid' : 'dash';
    return { name: axis, x: time, y: axes[axis]?.[key] ?? [], ink: INKS[axis], dash };
  });
  const y =
    key === 'force'
      ? { label: 'learnt force', unit: 'N' }
      : { label: 'following error', unit: 'm', scale: MICROMETRES };
  const title = key === 'force' ? 'Force over the lap' : 'Error of the last lap';
  return { title, x: { label: 'time', unit: 's' }, y, series, bands: [], marks: [] };
}

const MICROMETRES = { unit: 'µm', factor: 1e6 };

export interface LapRow {
  axis: Axis;
  /** Largest error of the first lap and of the last, measured and true, µm. */
  first: string;
  last: string;
  truth: string;
  /** Of the encoder, nm. */
  encoder: string;
}

/** How far learning has come on each axis. */
export function lapRows(laps: Laps, result: Pick<Learning, 'axes'> | null): LapRow[] {
  const um = (value: number | undefined) => (value === undefined ? '–' : digits(1e6 * value, 3));
  return axesOf(laps).map((axis) => {
    const own = laps[axis] ?? [];
    const last = own.at(-1);
    const encoder = result?.axes[axis]?.encoder;
    return {
      axis,
      first: um(own[0]?.peak),
      last: um(last?.peak),
      truth: um(last?.true_peak),
      encoder: encoder ? digits(1e9 * encoder.amplitude, 3) : '–',
    };
  });
}

/** The axes that a table has, in their order. */
function axesOf(table: object): Axis[] {
  return AXES.filter((axis) => axis in table);
}

/** In what the server says of a bandwidth at which an error would grow. */
export const DIVERGING = 'would diverge';

/** Whether a request is refused because learning would diverge, and for nothing else. */
export function diverges(problems: Readonly<Record<string, string>>): boolean {
  const all = Object.entries(problems);
  return (
    all.length > 0 &&
    all.every(([path, text]) => path.startsWith('bandwidth') && text.includes(DIVERGING))
  );
}

/** Says what a learnt force is; `period` of control, s. */
export function knownText(force: Pick<LearntForce, 'laps' | 'x'>, period: number): string {
  const ticks = Math.floor((0.75 * force.x.length) / BYTES);
  const lap = period > 0 ? ` of ${digits(ticks * period, 3)} s` : '';
  return `${show(LEARNT, force)}${lap}`;
}

/** The changes with which a scenario has no learnt force, and no controller that adds one. */
export function forgetting({ variants }: Pick<Scenario, 'variants'>): Changes {
  const off = Object.keys(variants).map((name) => [`variants.${name}.controller.learnt`, false]);
  return { [LEARNT]: null, ...Object.fromEntries(off) };
}
