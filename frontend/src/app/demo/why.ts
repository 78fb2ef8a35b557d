/** Why a following error peaks, as studies/why/explain.py finds it: the run again without each cause. */

import type { Axis } from '../../kernel/lanes';
import { at, equal } from '../api/scenario-paths';
import type { Changes, Scenario, Value, Why } from '../api/types';
import { NEEDS_SERVER } from './demo-mode';
import { Refused } from '../whatif/refused-changes';

/** What the server's own study uses, from studies/why: paths have `{controller}` and `{axis}` in them. */
export interface WhyData {
  /** Errors about a peak are taken so far before and after it, s. */
  reach: number;
  /** Goal as a share of the peak, where none is stated. */
  goal: number;
  causes: readonly CauseKind[];
}

export interface CauseKind {
  id: string;
  label: string;
  meaning: string;
  changes: readonly {
    /** With `*` every entry of a list. */
    path: string;
    value: Value;
    /** The field whose value it gets, in place of `value`; empty for none. */
    copied: string;
    /** Where one of these holds, nothing is changed. */
    unless: Readonly<Record<string, Value>>;
  }[];
}

export interface WhyRequest {
  scenario: Scenario;
  set?: Changes;
  variant: string;
  axis?: Axis | null;
  time?: number | null;
  goal?: number | null;
}

/** The run of a variant; ticks are those of the scenario. */
export interface WhyRun {
  /** As it holds throughout the run. */
  scenario: Scenario;
  moving: readonly Axis[];
  /** Ticks [first, stop) run. */
  first: number;
  stop: number;
  window: { start: number; end: number };
  /** Control period, s. */
  period: number;
  /** After which the motion repeats, s; null of one that ends. */
  lap: number | null;
  /** Following errors with each of some changes, of every axis, or why the page cannot run it. */
  errors(cases: readonly Changes[]): Promise<(Record<Axis, Float32Array> | string)[]>;
}

/** The changes that take a cause away; none where it is not there. */
export function changesOf(
  { changes }: CauseKind,
  scenario: Scenario,
  variant: string,
  axis: Axis,
): Changes {
  const whole = (path: string) =>
    path.replace('{controller}', `variants.${variant}.controller`).replace('{axis}', axis);
  const value = (path: string) => at(scenario, whole(path));
  return Object.fromEntries(
    changes.flatMap((change): [string, Value][] => {
      if (Object.entries(change.unless).some(([path, each]) => equal(value(path), each))) return [];
      const [path = '', entry] = whole(change.path).split('.*.');
      const now = at(scenario, path);
      const own = change.copied === '' ? change.value : value(change.copied);
      if (now === undefined || own === undefined) return [];
      const to =
        entry === undefined
          ? own
          : (now as object[]).map((each): Value => ({ ...each, [entry]: own }));
      return equal(now, to) ? [] : [[path, to]];
    }),
  );
}

/** @throws Refused where there is no such peak */
export async function explain(data: WhyData, request: WhyRequest, run: WhyRun): Promise<Why> {
  const { first, stop, window, period, scenario } = run;
  const { variant } = request;
  const { axis, tick, errors } = await peakOf(data, request, run);
  const reach = Math.round(data.reach / period);
  const near = { start: Math.max(first, tick - reach), end: Math.min(stop, tick + reach + 1) };
  const largest = (of: Record<Axis, Float32Array>, part = near) =>
    sizes(of[axis], part, first).reduce((a, b) => Math.max(a, b));
  const peak = largest(errors);
  const all = data.causes.map((kind) => ({ kind, set: changesOf(kind, scenario, variant, axis) }));
  const there = all.filter(({ set }) => Object.keys(set).length > 0);
  const results = await run.errors(there.map(({ set }) => set));
  const notes: string[] = [];
  const causes = there.flatMap(({ kind: { id, label, meaning }, set }, i): Why['causes'] => {
    const without = results[i] as Record<Axis, Float32Array> | string;
    if (typeof without === 'string') {
      notes.push(`Left out: ${label}. This page cannot run it: ${without}.`);
      return [];
    }
    const error = finite(largest(without));
    const share = error === null || peak === 0 ? null : 1 - error / peak;
    return [{ id, label, meaning, error, share, set }];
  });
  causes.sort((a, b) => rank(b) - rank(a));
  return {
    scenario: scenario.name,
    variant,
    axis,
    time: Number((tick * period).toFixed(7)),
    period: run.lap,
    window: [near.start * period, near.end * period],
    peak,
    window_peak: finite(largest(errors, window)),
    goal: request.goal ?? data.goal * peak,
    causes,
    absent: all
      .filter((each) => !there.includes(each))
      .map(({ kind: { id, label } }) => ({ id, label })),
    mend: null,
    why_not: NEEDS_SERVER,
    tried: 0,
    reached: 0,
    notes,
  };
}

/** How large errors are over a part of a run from tick `first`. */
function sizes(
  errors: Float32Array,
  { start, end }: { start: number; end: number },
  first: number,
) {
  return errors.subarray(start - first, end - first).map(Math.abs);
}

const rank = ({ share }: { share: number | null }) => share ?? Number.NEGATIVE_INFINITY;
const finite = (value: number) => (Number.isFinite(value) ? value : null);

/** The errors as they are, and the axis and the tick of the largest about a time, or in the window. */
async function peakOf(data: WhyData, request: WhyRequest, run: WhyRun) {
  const { first, stop, window, period, moving } = run;
  const { axis, time, variant } = request;
  const refused = (loc: string, message: string) => new Refused([{ loc, message }]);
  const axes = moving.filter((each) => !axis || each === axis);
  if (axes.length === 0) throw refused('axis', 'does not move in this scenario');
  let part = { ...window };
  if (time !== null && time !== undefined) {
    const [middle, reach] = [Math.round(time / period), Math.round(data.reach / period)];
    if (middle < first) {
      throw refused('time', `lies before ${first * period} s, from where on a demo runs this`);
    }
    if (middle >= stop) throw refused('time', 'lies after the end of the run');
    part = { start: Math.max(first, middle - reach), end: Math.min(stop, middle + reach + 1) };
  }
  const [errors] = await run.errors([{}]);
  if (!errors || typeof errors === 'string') throw new Error(errors);
  const places = axes.map((each) => {
    const own = sizes(errors[each], part, first);
    const largest = own.reduce((a, b) => Math.max(a, b));
    if (!Number.isFinite(largest)) {
      throw refused(`variants.${variant}`, 'diverges before that: there is no peak to explain');
    }
    return { axis: each, largest, tick: part.start + own.indexOf(largest) };
  });
  // Of two that are equal the later axis, as there.
  const worst = places.reduce((a, b) => (b.largest >= a.largest ? b : a));
  return { ...worst, errors };
}
