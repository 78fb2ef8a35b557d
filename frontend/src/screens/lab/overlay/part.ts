/** Overlaid runs, which are loaded with the first of them. */

export { overlay } from '../../../parts/overlay/overlay.svelte';
export { behind, movers } from '../../../plot/ghosts';
export { overlaidColumns } from './columns';
export { default as OverlaidMetrics } from './OverlaidMetrics.svelte';
export { default as OverlaidRuns } from './OverlaidRuns.svelte';
