/** The list of captures: those of the trigger, and those that are runs, with figures to compare. */

import type { Axis, Run } from '../../app/api/types';
import { whenText } from '../../parts/runs/run-text';
import { extremes } from '../../plot/source';
import { type Capture, samplesOf } from './captures';
import { type Condition } from './detector';
import { glitchHeight } from './glitch';

export interface CaptureRow {
  key: string;
  /** When it was triggered, s; NaN where that is not known. */
  time: number;
  /** Of the channel that is measured, SI; NaN where it is not known. */
  peak: number;
  /** Of the following error that is measured, m. */
  glitch: number;
  /** The run that it is; empty while it is none. */
  run: string;
  /** Why it is none, or that it is being kept. */
  state: '' | 'keeping' | 'refused';
  pinned: boolean;
}

export interface CaptureGroup {
  key: string;
  title: string;
  rows: readonly CaptureRow[];
}

export interface Listed {
  /** Those of the present trigger, in the order of time. */
  hits: readonly Capture[];
  /** Those that are runs, the newest first. */
  runs: readonly Run[];
  /** The run that the session is recorded as. */
  session: string;
  /** What hits are of that are of no session. */
  subject: string;
  /** The channel whose peaks are listed, and the following error whose glitches are. */
  peakOf: string;
  glitchOf: string;
  /** Of the encoder of an axis, m. */
  resolution: (axis: Axis) => number;
  /** Seconds since 1970. */
  now: number;
}

const ERROR = /^[A-Z]\.([xy])\.following_error$/;

/** The groups of captures, each of what they were taken of: the present first, then the newest. */
export function captureGroups(listed: Listed): CaptureGroup[] {
  const { hits, runs, session, subject, now } = listed;
  const groups = new Map<string, CaptureGroup & { rows: CaptureRow[] }>();
  const put = (key: string, title: string, row: CaptureRow) => {
    const group = groups.get(key) ?? { key, title, rows: [] };
    group.rows.push(row);
    groups.set(key, group);
  };
  const byId = new Map(runs.map((run) => [run.id, run]));
  const here = new Set(hits.map(({ run }) => run));
  // Of a session the newest is wanted first; hits of a record are in the order of their time.
  const ordered = hits[0]?.apart ? [...hits].reverse() : hits;
  for (const hit of ordered) {
    const row = rowOf(hit, byId.get(hit.run), listed);
    if (hit.apart) put('session', 'This session', row);
    else put('subject', subject, row);
  }
  for (const run of runs) {
    if (here.has(run.id)) continue;
    const origin = run.capture?.origin ?? '';
    const present = origin !== '' && origin === session;
    const whatIf = run.kind === 'simulation' ? ', what-if' : '';
    const title = `${whenText(run.created, now)}, ${run.scenario}${whatIf}`;
    const key = present ? 'session' : origin || `${run.kind} ${run.scenario}`;
    put(key, present ? 'This session' : title, keptRow(run, listed));
  }
  return [...groups.values()];
}

function rowOf(hit: Capture, run: Run | undefined, listed: Listed): CaptureRow {
  const state = hit.run === '…' ? 'keeping' : hit.problem === '' ? '' : 'refused';
  const kept = run && keptRow(run, listed);
  return {
    key: hit.key,
    time: hit.time,
    peak: known(kept?.peak, () => peakOf(hit, listed.peakOf)),
    glitch: known(kept?.glitch, () => glitchOf(hit, listed)),
    run: run?.id ?? (hit.run === '…' ? '' : hit.run),
    state,
    pinned: run?.pinned ?? false,
  };
}

function keptRow({ id, capture, period, pinned }: Run, listed: Listed): CaptureRow {
  return {
    key: id,
    time: capture ? capture.trigger_tick * period : Number.NaN,
    peak: capture?.peaks[listed.peakOf] ?? Number.NaN,
    glitch: capture?.glitches[listed.glitchOf] ?? Number.NaN,
    run: id,
    state: '',
    pinned,
  };
}

function known(value: number | undefined, computed: () => number): number {
  return value === undefined || Number.isNaN(value) ? computed() : value;
}

/** The sample farthest from zero. */
function peakOf({ source, range }: Capture, column: string): number {
  if (!source.has(column)) return Number.NaN;
  const [low, high] = extremes(source, column, range);
  return Math.abs(low) > Math.abs(high) ? low : high;
}

function glitchOf(hit: Capture, { glitchOf: column, resolution }: Listed): number {
  const { source, time } = hit;
  const axis = ERROR.exec(column)?.[1] as Axis | undefined;
  const velocity = `${axis}.velocity_reference`;
  if (!axis || !source.has(column) || !source.has(velocity)) return Number.NaN;
  const trigger = Math.round((time - source.start) / source.step);
  const settings = { trigger, count: resolution(axis), period: source.step };
  const error = samplesOf(source, column);
  return glitchHeight(samplesOf(source, velocity), error, settings) ?? Number.NaN;
}

/**
 * The channel whose peaks tell most of captures: that of a level or a window, else the following error on
 * the axis that reverses, else the first one that is shown.
 */
export function measuredChannel(
  conditions: readonly Condition[],
  columns: readonly string[],
): string {
  const level = conditions.find(({ kind }) => kind === 'level' || kind === 'window');
  if (level && 'channel' in level) return level.channel;
  const errors = columns.filter((column) => ERROR.test(column));
  const turned = conditions.flatMap((each) => (each.kind === 'reversal' ? [each.channel] : []));
  const axes = turned.flatMap((channel) => /(?:^|\.)([xy])\./.exec(channel)?.[1] ?? []);
  const onAxis = errors.find((column) => axes.includes(ERROR.exec(column)?.[1] ?? ''));
  return onAxis ?? errors[0] ?? columns[0] ?? '';
}

/** The following error whose glitches are listed with the peaks of a channel: of the same axis and variant. */
export function glitchChannel(peakOf: string, columns: readonly string[]): string {
  const [, variant, axis] = /^(?:([A-Z])\.)?([xy])\./.exec(peakOf) ?? [];
  const errors = columns.filter((column) => ERROR.test(column));
  if (variant && axis) return `${variant}.${axis}.following_error`;
  return errors.find((column) => column.includes(`.${axis}.`)) ?? errors[0] ?? '';
}
