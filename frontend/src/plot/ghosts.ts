/** Runs behind the curves of others: hue says variant, dash says run. */

import { GhostCurve, GhostPath } from './ghost';
import type { Range } from './range';
import type { Trace, Traces } from './scope-chart';
import type { SampleSource } from './source';
import type { Dash, Look } from './types';
import type { PathUnderlay, Underlay } from './underlay';

const DASHES: readonly Dash[] = ['long', 'dot', 'dashdot', 'dash'];

export interface GhostRun {
  readonly shown: boolean;
  /** Tells it from the others: 0 to 3. */
  readonly slot: number;
  has(column: string): boolean;
  /** Its curves over a stretch of time of what it lies behind. */
  over(range: Range): SampleSource | null;
}

interface Drawn<T> {
  source: SampleSource;
  list: readonly T[];
}

const curves = new WeakMap<GhostRun, WeakMap<Traces, Drawn<Underlay>>>();
const paths = new WeakMap<GhostRun, Drawn<PathUnderlay>>();

function dashOf({ slot }: GhostRun): Dash {
  return DASHES[slot] ?? 'long';
}

/** The look of a run in legends. */
export function lookOf(run: GhostRun): Look {
  return { dash: dashOf(run), width: 2 };
}

/** Traces of a scope that a run has too; references would cover each other. */
export function tracesOf(run: GhostRun, { traces }: Traces): Trace[] {
  return traces.filter(
    ({ column, ink }) => run.has(column) && ink !== 'difference' && !column.endsWith('_reference'),
  );
}

/** What lies behind a scope: the same channels of the runs. */
export function behind(
  runs: readonly GhostRun[],
  scope: Traces,
  range: Range,
): readonly Underlay[] {
  return runs.flatMap((run) => {
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
export function movers(
  runs: readonly GhostRun[],
  variants: readonly string[],
  range: Range,
): readonly PathUnderlay[] {
  return runs.flatMap((run) => {
    const source = run.shown ? run.over(range) : null;
    if (!source) return [];
    const drawn = paths.get(run);
    if (drawn?.source === source) return drawn.list;
    const list = variants.flatMap((variant) =>
      source.has(`${variant}.x.following_error`)
        ? [new GhostPath(source, variant, dashOf(run))]
        : [],
    );
    paths.set(run, { source, list });
    return list;
  });
}
