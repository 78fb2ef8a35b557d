/** A drawn path as the editor holds it, and what a person does to it; all in SI, nothing in place. */

import type { Trajectory } from '../../app/api/types';
import { clean } from '../../ui/units';

export type Point = readonly [x: number, y: number];
export type Law = 'minimum_jerk' | 'trapezoid' | 'jerk_limited' | 'time_optimal' | 'constant_speed';

export type Table = Trajectory;

export interface DrawnPath {
  kind: 'path';
  points: readonly Point[];
  closed: boolean;
  geometry: 'polyline' | 'spline';
  /** Points at which a spline has a corner; absent where it has none. */
  corners?: readonly number[];
  law: Law;
  v_max: number | null;
  a_max: number | null;
  j_max: number | null;
  lap_time: number | null;
  laps: number;
  /** Whether a live session repeats it for ever; it does where this is absent. */
  for_ever?: boolean;
  dwell: number;
  planned_for?: null;
}

/** Bounds of a listed coordinate, m; the stroke is smaller. */
const FARTHEST = 1;

export const TIMING = { v_max: 0.08, a_max: 0.8, j_max: 20 };

export function newPath(points: readonly Point[], closed: boolean): DrawnPath {
  return {
    kind: 'path',
    points,
    closed,
    geometry: 'polyline',
    law: 'minimum_jerk',
    v_max: TIMING.v_max,
    a_max: TIMING.a_max,
    j_max: null,
    lap_time: null,
    laps: 1,
    dwell: 0,
  };
}

/** Returns a table as a drawn path, or null when it is of another kind. */
export function asPath(table: Table | null): DrawnPath | null {
  if (table?.kind !== 'path') return null;
  const path = table as unknown as DrawnPath;
  // Edited, it is planned anew, for the motor of the scenario that it is edited in.
  return path.planned_for ? { ...path, planned_for: null } : path;
}

/** Returns what was kept of a trajectory, or null where it cannot be one. */
export function keptTable(kept: unknown): Table | null {
  if (typeof kept !== 'object' || kept === null || !('kind' in kept)) return null;
  if (kept.kind !== 'path') return typeof kept.kind === 'string' ? (kept as Table) : null;
  const isPoint = (point: unknown) =>
    Array.isArray(point) && point.length === 2 && point.every((value) => Number.isFinite(value));
  const points = 'points' in kept ? kept.points : null;
  return Array.isArray(points) && points.every(isPoint) ? (kept as unknown as Table) : null;
}

export function asTable(path: DrawnPath): Table {
  return path as unknown as Table;
}

/** Fewest points with which a path can be run. */
export function fewest(path: DrawnPath): number {
  return path.closed ? 3 : 2;
}

function bounded(value: number): number {
  return clean(Math.min(FARTHEST, Math.max(-FARTHEST, value)));
}

/** Returns a coordinate on the grid of `step`, m; 0 leaves it where it is, to a nanometre. */
export function snap(value: number, step: number): number {
  const grid = step > 0 ? step : 1e-9;
  return bounded(Math.round(value / grid) * grid) + 0;
}

export function moved(path: DrawnPath, index: number, [x, y]: Point): DrawnPath {
  const points = path.points.map((point, i): Point => {
    return i === index ? [bounded(x), bounded(y)] : point;
  });
  return { ...path, points };
}

/** Returns the whole path moved by a distance, m. */
export function shifted(path: DrawnPath, [dx, dy]: Point): DrawnPath {
  const points = path.points.map(([x, y]): Point => [bounded(x + dx), bounded(y + dy)]);
  return { ...path, points };
}

/** Returns the path with a point put in before the one at `index`; at the end, appended. */
export function inserted(path: DrawnPath, index: number, [x, y]: Point): DrawnPath {
  const point: Point = [bounded(x), bounded(y)];
  const points = [...path.points.slice(0, index), point, ...path.points.slice(index)];
  return withCorners({ ...path, points }, (at) => (at < index ? at : at + 1));
}

export function removed(path: DrawnPath, index: number): DrawnPath {
  return withoutPoints(path, new Set([index]));
}

export function withoutPoints(path: DrawnPath, chosen: ReadonlySet<number>): DrawnPath {
  const points = path.points.filter((_, i) => !chosen.has(i));
  const closed = path.closed && points.length >= 3;
  const rest = { ...path, points, closed, laps: closed ? path.laps : 1 };
  const before = (at: number) => [...chosen].filter((each) => each < at).length;
  return withCorners(rest, (at) => (chosen.has(at) ? null : at - before(at)));
}

/** Returns the path with some of its points elsewhere, to a nanometre. */
export function withPlaces(
  path: DrawnPath,
  chosen: ReadonlySet<number>,
  to: (point: Point) => Point,
): DrawnPath {
  const points = path.points.map((point, i): Point => {
    if (!chosen.has(i)) return point;
    const [x, y] = to(point);
    return [snap(x, 0), snap(y, 0)];
  });
  return { ...path, points };
}

/** Returns the path under another geometry; straight edges have no corners of their own to name. */
export function withGeometry(path: DrawnPath, geometry: DrawnPath['geometry']): DrawnPath {
  return withCorners({ ...path, geometry }, (at) => (geometry === 'spline' ? at : null));
}

/** Returns the path with its corners at the points that they have become. */
function withCorners(path: DrawnPath, become: (at: number) => number | null): DrawnPath {
  if (!path.corners) return path;
  return { ...path, corners: path.corners.map(become).filter((at) => at !== null) };
}

export function withClosed(path: DrawnPath, closed: boolean): DrawnPath {
  return { ...path, closed, laps: closed ? path.laps : 1 };
}

/** Returns the path under another law, with what that law needs and nothing else. */
export function withLaw(path: DrawnPath, law: Law): DrawnPath {
  const base = law === 'time_optimal' && path.lap_time !== null ? byLimits(path) : path;
  const limited = needsJerk(law) && base.lap_time === null;
  return { ...base, law, j_max: limited ? (base.j_max ?? TIMING.j_max) : null };
}

/** Returns the path timed by its limits, or by the time of a lap. */
export function timedBy(path: DrawnPath, by: 'limits' | 'time', lap: number): DrawnPath {
  if (by === 'time') return { ...path, v_max: null, a_max: null, j_max: null, lap_time: lap };
  return withLaw(byLimits(path), path.law);
}

function byLimits(path: DrawnPath): DrawnPath {
  return { ...path, v_max: TIMING.v_max, a_max: TIMING.a_max, lap_time: null };
}

/** Returns whether a law limits the jerk. */
export function needsJerk(law: Law): boolean {
  return law === 'jerk_limited' || law === 'time_optimal';
}

/** Returns the first point that is the same as the one after it, or null. */
export function repeated({ points, closed }: DrawnPath): number | null {
  const last = closed ? points.length : points.length - 1;
  for (let i = 0; i < last; i++) {
    const [a, b] = [points[i] as Point, points[(i + 1) % points.length] as Point];
    if (a[0] === b[0] && a[1] === b[1]) return i;
  }
  return null;
}

/** Returns which points lie outside the stroke, half of it given per axis, m. */
export function outside(points: readonly Point[], stroke: Point): number[] {
  const slack = 1e-12;
  return points.flatMap(([x, y], i) =>
    Math.abs(x) > stroke[0] + slack || Math.abs(y) > stroke[1] + slack ? [i] : [],
  );
}
