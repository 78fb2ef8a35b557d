/** Which samples and channels of a run are shown. */

import { AXES, type RunDetail } from '../../app/api/types';
import type { Length } from '../../app/runs/run-range';
import type { Range } from '../../plot/range';
import { type ScopeSpec, scopeWith } from '../../plot/scope-layout';

/** How much of a run that is played the plane shows at once, s. */
const PAGE_SECONDS = 12;
/** Channels that are shown of a run without following errors. */
const FEW = 2;

/** Says why a run has no plane; empty where it has. */
export function withoutPlane({ columns }: Pick<RunDetail, 'columns'>): string {
  const missing = AXES.map((axis) => `${axis}.position_reference`).filter((reference) =>
    columns.every(({ name }) => name !== reference),
  );
  return missing.length === 0 || columns.length === 0
    ? ''
    : `No plane: it has no ${missing.join(', no ')}. Its channels are below, over time.`;
}

/** Returns the window of a run's metrics, from its first sample on; null without one. */
export function measuredWindow(run: Pick<RunDetail, 'result' | 'first_tick' | 'period'>) {
  const { window } = run.result as { window?: { start: number; end: number } };
  const begun = run.first_tick * run.period;
  return window ? { start: window.start - begun, end: window.end - begun } : null;
}

/** Returns what the plane shows: the part that is looked at, or the metrics' window, all of it. */
export function planeRange(run: RunDetail, zoom: Range | null): Range | null {
  if (run.ticks === 0 || withoutPlane(run) !== '') return null;
  if (zoom) return zoom;
  const window = measuredWindow(run);
  return { from: window?.start ?? 0, to: Math.min(window?.end ?? run.duration, run.duration) };
}

/** Returns the pages of a long path by their number: what the plane shows while a moment moves. */
export function planePage(page: number, { duration }: Length): Range {
  const half = PAGE_SECONDS / 2;
  const from = Math.max(0, Math.min(half * page - half / 2, duration - PAGE_SECONDS));
  return { from, to: Math.min(duration, from + PAGE_SECONDS) };
}

/** The page on which a moment is. */
export function pageOf(time: number): number {
  return Math.floor((2 * time) / PAGE_SECONDS);
}

/** Returns the scopes of a run: following errors of all variants; of one without any, its first channels. */
export function errorScopes(run: RunDetail): ScopeSpec[] {
  const names = run.columns.map(({ name = '' }) => name);
  const errors = AXES.map((axis) => {
    const rest = `${axis}.following_error`;
    const places = [...run.variants.map((variant) => `${variant}.${rest}`), rest];
    return places.filter((column) => names.includes(column));
  }).filter((channels) => channels.length > 0);
  const channels = errors.length > 0 ? errors : names.slice(0, FEW).map((name) => [name]);
  return channels.map((each) => scopeWith(...each));
}
