import { innerHeight } from 'svelte/reactivity/window';

/** Height of a plot of a view: a share of the window's, CSS pixels. */
export function plotHeight(share: number, least: number): number {
  return Math.max(least, Math.round(share * (innerHeight.current ?? 0)));
}
