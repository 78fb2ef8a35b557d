/** How a person looks at curves, as an address carries it: time range, cursors, readings. */

import { parsed } from '../app/storage';
import { STATISTICS } from './statistics';
import type { TimeView } from './time-view.svelte';

export interface Look {
  zoom?: unknown;
  cursors?: unknown;
  /** Values of cursors, by the place of their scope. */
  levels?: unknown;
  statistic?: unknown;
  measuring?: unknown;
}

/** Times in an address are rounded to this, s: far below a sample. */
const ROUND = 1e-7;
const PLACES_MAX = 12;

/** Returns a time of an address. */
export function rounded(time: number): number {
  return Number((Math.round(time / ROUND) * ROUND).toFixed(7));
}

/** Returns how a view is looked at, with times so much later; nothing that is as usual. */
export function lookOf(view: TimeView, later = 0): Look {
  const { zoom, cursors, statistic, measuring } = view;
  const levels = Object.entries(view.levels).filter(([, values]) => values.length > 0);
  return {
    ...(zoom && { zoom: [rounded(zoom.from + later), rounded(zoom.to + later)] }),
    ...(cursors.length > 0 && { cursors: cursors.map((time) => rounded(time + later)) }),
    ...(levels.length > 0 && { levels: Object.fromEntries(levels) }),
    ...(statistic !== 'value' && { statistic }),
    ...(measuring && { measuring }),
  };
}

/** Reads a look, with whatever else is in it; what is damaged is left out. */
export function readLook<T extends Look>(text: string | null): T {
  return parsed<T>(text, {} as T);
}

/** Has a view looked at so. */
export function takeLook(view: TimeView, { zoom, cursors, levels, statistic, measuring }: Look) {
  const known = STATISTICS.find(({ id }) => id === statistic);
  if (known) view.statistic = known.id;
  const [from, to] = numbers(zoom);
  if (from !== undefined && to !== undefined && to > from) view.zoom = { from, to };
  view.cursors = numbers(cursors);
  if (typeof levels === 'object' && levels !== null) {
    const places = Object.entries(levels).slice(0, PLACES_MAX);
    view.levels = Object.fromEntries(places.map(([place, values]) => [place, numbers(values)]));
  }
  if (measuring === true) view.measuring = true;
}

/** Two numbers at most. */
function numbers(value: unknown): number[] {
  return Array.isArray(value) ? value.filter(Number.isFinite).slice(0, 2).map(Number) : [];
}
