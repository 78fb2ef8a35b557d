/** How overlaid runs are drawn: hue says variant, dash says run. */

import type { OverlaidRun } from '../../../app/overlay/overlaid-run.svelte';
import { overlay } from '../../../app/overlay/overlay.svelte';
import { GhostCurve, GhostPath } from '../../../plot/ghost';
import type { Range } from '../../../plot/range';
import type { Trace, Traces } from '../../../plot/scope-chart';
import type { SampleSource } from '../../../plot/source';
import type { Dash, Look } from '../../../plot/types';
import type { PathUnderlay, Underlay } from '../../../plot/underlay';

const DASHES: readonly Dash[] = ['long', 'dot', 'dashdot', 'dash'];

interface Drawn<T> {
  source: SampleSource;
  list: readonly T[];
}

const curves = new WeakMap<OverlaidRun, WeakMap<Traces, Drawn<Underlay>>>();
const paths = new WeakMap<OverlaidRun, Drawn<PathUnderlay>>();

function dashOf({ slot }: OverlaidRun): Dash {
  return DASHES[slot] ?? 'long';
}

/** The look of a run in legends. */
export function lookOf(run: OverlaidRun): Look {
  return { dash: dashOf(run), width: 2 };
}

/** Traces of a scope that a run has too; references would cover each other. */
export function tracesOf(run: OverlaidRun, { traces }: Traces): Trace[] {
  return traces.filter(({ column }) => run.has(column) && !column.endsWith('_reference'));
}

/** What lies behind a scope: the same channels of the runs. */
export function behind(scope: Traces, range: Range): readonly Underlay[] {
  return overlay.list.flatMap((run) => {
    const source = run.shown ? run.over(range) : null;
    if (!source) return [];
    const scopes = curves.get(run) ?? new WeakMap<Traces, Drawn<Underlay>>();
    curves.set(run, scopes);
    const drawn = scopes.get(scope);
    if (drawn?.source === source) return drawn.list;
    const list = tracesOf(run, scope).map((trace) => new GhostCurve(source, trace, dashOf(run)));
    scopes.set(scope, { source, list });
    return list;
  });
}

/** Paths of the movers of the runs. */
export function movers(variants: readonly string[], range: Range): readonly PathUnderlay[] {
  return overlay.list.flatMap((run) => {
    const source = run.shown ? run.over(range) : null;
    if (!source) return [];
    const drawn = paths.get(run);
    if (drawn?.source === source) return drawn.list;
    const list = variants.flatMap((variant, i) =>
      source.has(`${variant}.x.following_error`)
        ? [new GhostPath(source, variant, i, dashOf(run))]
        : [],
    );
    paths.set(run, { source, list });
    return list;
  });
}
