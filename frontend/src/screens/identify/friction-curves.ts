/** From points and parameters to what the plots draw. */

import type { AxisIdentification } from '../../app/api/types';
import type { PlotAxis, Band, Series } from '../../plot/types';

/** Signed velocity on a linear axis, or both ways folded together over the logarithm of speed. */
export type CurveView = 'signed' | 'folded';

export type Friction = Readonly<Record<string, number>>;
export type Points = AxisIdentification['points'];

const SAMPLES = 120;

/** Force of uniform motion, N: eqs (20) to (22) with dz/dt = 0. */
export function stribeck(friction: Friction, v: number): number {
  const { F_c = 0, F_s = 0, v_s = 1, sigma_2 = 0, f_0 = 0 } = friction;
  const level = F_c + (F_s - F_c) * Math.exp(-((v / v_s) ** 2));
  return Math.sign(v) * level + sigma_2 * v + f_0;
}

/** Speeds at which a curve is drawn, m/s: close together where it bends. */
function speeds(slowest: number, fastest: number): number[] {
  const from = 0.5 * slowest;
  return Array.from({ length: SAMPLES }, (_, k) => from * (fastest / from) ** (k / (SAMPLES - 1)));
}

export interface SpeedRange {
  slowest: number;
  fastest: number;
}

/** The range of speeds of points, or of the motions that are planned. */
export function rangeOf(points: Points, planned: readonly { speed: number }[]): SpeedRange | null {
  const all = [...points.map(({ velocity }) => Math.abs(velocity)), ...planned.map((p) => p.speed)];
  return all.length === 0 ? null : { slowest: Math.min(...all), fastest: Math.max(...all) };
}

/** The curve of a model, both ways with a gap at zero, or folded. */
export function modelCurve(
  friction: Friction,
  { slowest, fastest }: SpeedRange,
  view: CurveView,
): { x: number[]; y: number[] } {
  const way = speeds(slowest, fastest);
  if (view === 'folded') return { x: way, y: way.map((v) => stribeck(friction, v)) };
  const x = [...way.map((v) => -v).reverse(), 0, ...way];
  return { x, y: x.map((v) => (v === 0 ? Number.NaN : stribeck(friction, v))) };
}

/** The axis of velocity, or of speed, with room beside the fastest points. */
export function velocityAxis(range: SpeedRange | null, view: CurveView): PlotAxis {
  if (view === 'folded') return { label: 'speed', unit: 'm/s', log: true };
  const end = 1.04 * (range?.fastest ?? 0);
  const ends = end > 0 ? { from: -end, to: end } : {};
  return { label: 'velocity', unit: 'm/s', ...ends };
}

/** Measured values over velocity; folded, each direction is a series of its own. */
export function pointSeries(
  points: Points,
  values: readonly number[],
  name: string,
  view: CurveView,
): Series[] {
  const pick = (keep: (v: number) => boolean, sign: 1 | -1) => {
    const at = points.flatMap(({ velocity }, i) => (keep(velocity) ? [i] : []));
    return {
      x: at.map((i) => sign * (points[i]?.velocity ?? 0)),
      y: at.map((i) => sign * (values[i] ?? Number.NaN)),
    };
  };
  if (view === 'signed') {
    return [{ name, ...pick(() => true, 1), kind: 'points', ink: 'text', marker: 'circle' }];
  }
  const forth = pick((v) => v > 0, 1);
  const back = pick((v) => v < 0, -1);
  return [
    { name: 'v > 0', ...forth, kind: 'points', ink: 'text', marker: 'circle' },
    { name: 'v < 0', ...back, kind: 'points', ink: 'muted', marker: 'triangle' },
  ];
}

type Curve = AxisIdentification['curve'];

/** The fitted curve; folded, its positive half less the offset is what both ways share. */
export function fittedCurve(curve: Curve, view: CurveView): { x: number[]; y: number[] } {
  const { velocity, force } = curve;
  if (view === 'signed') return gapped(velocity, force);
  const from = velocity.findIndex((v) => v > 0);
  return { x: velocity.slice(from), y: folded(force) };
}

/** The band around the fitted curve, or around zero for the residuals. */
export function bandOf(curve: Curve, view: CurveView, about: 'curve' | 'zero'): Band[] {
  const { velocity, force, low, high } = curve;
  if (!low || !high) return [];
  const shift = (edge: readonly number[]) =>
    about === 'curve' ? [...edge] : edge.map((value, i) => value - (force[i] ?? 0));
  const [bottom, top] = [shift(low), shift(high)];
  const ink = 'b' as const;
  const name = '95 % band';
  if (view === 'signed') {
    const { x, y } = gapped(velocity, bottom);
    return [{ name, x, low: y, high: gapped(velocity, top).y, ink }];
  }
  const { x, y } = fittedCurve(curve, view);
  const from = velocity.length - x.length;
  // The band belongs to one way: around the folded curve it lies without the offset.
  const offset = x.map((_, k) => (about === 'curve' ? (force[from + k] ?? 0) - (y[k] ?? 0) : 0));
  const moved = (edge: readonly number[]) => offset.map((off, k) => (edge[from + k] ?? 0) - off);
  return [{ name, x, low: moved(bottom), high: moved(top), ink }];
}

/** Half the difference of both ways: what an offset of force leaves. */
function folded(force: readonly number[]): number[] {
  const from = force.length / 2;
  return force.slice(from).map((value, k) => 0.5 * (value - (force[from - 1 - k] ?? 0)));
}

function gapped(x: readonly number[], y: readonly number[]): { x: number[]; y: number[] } {
  const middle = x.findIndex((v) => v > 0);
  return {
    x: [...x.slice(0, middle), 0, ...x.slice(middle)],
    y: [...y.slice(0, middle), Number.NaN, ...y.slice(middle)],
  };
}

/** Where the planned motions will be measured, on the curve that is believed. */
export function plannedSeries(
  motions: readonly { speed: number }[],
  believed: Friction,
  view: CurveView,
): Series {
  const way = motions.map(({ speed }) => speed);
  const x = view === 'folded' ? way : [...way.map((v) => -v).reverse(), ...way];
  const y = x.map((v) => stribeck(believed, v));
  return { name: 'planned', x, y, kind: 'points', ink: 'muted', marker: 'plus' };
}

type Ramp = AxisIdentification['ramps'][number];

/** Of a ramp, that are drawn as points. */
const DRAWN = 60;

/** Force over displacement of one ramp: measured, the fitted loop, and the line of sigma_0. */
export function presliding(ramp: Ramp, sigma_0: number | undefined): Series[] {
  const { force, displacement, fitted, force_max } = ramp;
  const step = Math.ceil(force.length / DRAWN);
  const thin = (values: readonly number[]) => values.filter((_, i) => i % step === 0);
  const series: Series[] = [
    {
      name: 'measured',
      x: thin(displacement),
      y: thin(force),
      kind: 'points',
      ink: 'text',
      marker: 'circle',
    },
    { name: 'fitted', x: fitted, y: force, ink: 'b' },
  ];
  if (sigma_0 !== undefined && sigma_0 > 0) {
    series.push({
      name: 'σ_0 x',
      x: [0, force_max / sigma_0],
      y: [0, force_max],
      ink: 'reference',
      dash: 'dot',
    });
  }
  return series;
}
