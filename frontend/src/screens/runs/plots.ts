/** The curves that the keys of the screen act on. */

import type { RunCurves } from './run-curves.svelte';

export const plots: { current: RunCurves | null } = { current: null };
