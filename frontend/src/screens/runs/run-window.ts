/** Which samples and channels of a run are shown. */

import { AXES, type RunDetail } from '../../app/api/types';
import type { Length } from '../../app/runs/run-range';
import type { Range } from '../../plot/range';
import type { Traces } from '../../plot/scope-chart';
import { looksOf } from '../../plot/variant-looks';

/** Longest stretch that the plane shows, s: laps of a longer one would cover each other. */
const PLANE_SECONDS = 12;
/** Shortest time axis, in samples. */
const LEAST = 8;
/** Span of an error's value axis while all is zero, m. */
const STILL = 1e-5;

/** Returns a stretch within the run, no shorter than a few samples; null for the whole. */
export function zoomed({ from, to }: Range, { period, duration }: Length): Range | null {
  const length = Math.max(to - from, LEAST * period);
  if (length >= duration) return null;
  const start = Math.min(Math.max(0, from), duration - length);
  return { from: start, to: start + length };
}

/** Says why a run has no plane; empty where it has. */
export function withoutPlane({ columns }: Pick<RunDetail, 'columns'>): string {
  const missing = AXES.map((axis) => `${axis}.position_reference`).filter((wanted) =>
    columns.every(({ name }) => name !== wanted),
  );
  return missing.length === 0 || columns.length === 0
    ? ''
    : `No plane: it has no ${missing.join(', no ')}. Its channels are below, over time.`;
}

/** Returns what the plane shows: the part that is looked at or the metrics' window, its end. */
export function planeRange(run: RunDetail, zoom: Range | null): Range | null {
  if (run.ticks === 0 || withoutPlane(run) !== '') return null;
  const { window } = run.result as { window?: { start: number; end: number } };
  const { from, to } = zoom ?? {
    from: window?.start ?? 0,
    to: Math.min(window?.end ?? run.duration, run.duration),
  };
  return { from: Math.max(from, to - PLANE_SECONDS), to };
}

/** Returns the pages of a long path by their number: what the plane shows while a moment moves. */
export function planePage(page: number, { duration }: Length): Range {
  const half = PLANE_SECONDS / 2;
  const from = Math.max(0, Math.min(half * page - half / 2, duration - PLANE_SECONDS));
  return { from, to: Math.min(duration, from + PLANE_SECONDS) };
}

/** The page on which a moment is. */
export function pageOf(time: number): number {
  return Math.floor((2 * time) / PLANE_SECONDS);
}

export interface Scope extends Traces {
  title: string;
}

/** Returns the scopes: following errors of all variants, and a channel if one is chosen. */
export function scopesOf(run: RunDetail, channel: string): Scope[] {
  const units = new Map(run.columns.map(({ name, unit }) => [name, unit ?? '1']));
  const scope = (title: string, name: string): Scope => {
    const places = [...run.variants.map((variant) => `${variant}.${name}`), name];
    const traces = places
      .map((column, i) => ({
        column,
        label: run.variants[i] ?? name,
        ...looksOf(run.variants[i] ?? 'A'),
      }))
      .filter(({ column }) => units.has(column));
    return { title, unit: units.get(traces[0]?.column ?? '') ?? '1', traces };
  };
  const errors = AXES.map((axis) => ({
    ...scope(`Following error ${axis}`, `${axis}.following_error`),
    still: STILL,
  }));
  const others = channel === '' ? [] : [scope(channelTitle(channel), channel)];
  return [...errors, ...others].filter(({ traces }) => traces.length > 0);
}

/** Returns the channels of a run without their variant: `x.velocity`. */
export function channelsOf(run: RunDetail): { value: string; name: string }[] {
  const names = run.columns.map(({ name = '' }) => name.replace(/^[A-Z]\.(?=[xy]\.)/, ''));
  return [...new Set(names)]
    .filter((name) => !name.endsWith('.following_error'))
    .map((value) => ({ value, name: channelTitle(value) }));
}

function channelTitle(channel: string): string {
  const [, axis, name] = /^([xy])\.(.+)$/.exec(channel) ?? [];
  return axis === undefined || name === undefined
    ? channel.replaceAll('_', ' ')
    : `${name.replaceAll('_', ' ')} ${axis}`;
}
