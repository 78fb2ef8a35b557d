/** What is said of runs in words. */

import { ApiError } from '../../app/api/client';
import type {
  Replay,
  Run,
  RunDetail,
  RunDifference,
  RunEvent,
  RunStorage,
  Value,
} from '../../app/api/types';
import { errorText } from '../../app/error-text';
import { lawText } from '../../app/session/law-text';
import { fieldOf, nameOf, show } from '../../app/fields/fields.svelte';
import {
  digits,
  durationText,
  minus,
  pretty,
  prettyUnit,
  scaleOf,
  speedText,
} from '../../ui/units';

const STOP = 'STOP';
/** Kinds of which there is no more to say than who did it. */
const DONE: Record<string, string> = {
  [STOP]: 'stopped',
  play: 'played',
  pause: 'paused',
  reset: 'reset',
};
const MINUTE = 60;
const HOUR = 3600;
const DAY = 24 * HOUR;
const SIZES = [
  [1e9, 'GB'],
  [1e6, 'MB'],
  [1e3, 'kB'],
] as const;

export const KINDS: Readonly<Record<Run['kind'], string>> = {
  simulation: 'simulated',
  live: 'live session',
  drive: 'on drives',
  measurement: 'measured',
};

/** When something was, both in seconds since 1970: relative today, a date otherwise. */
export function whenText(then: number, now: number): string {
  const ago = now - then;
  const date = new Date(then * 1000);
  const today = new Date(now * 1000);
  if (date.toDateString() === today.toDateString() || (ago >= 0 && ago < HOUR)) {
    if (ago < MINUTE) return 'just now';
    if (ago < HOUR) return `${Math.floor(ago / MINUTE)} min ago`;
    return `${Math.floor(ago / HOUR)} h ago`;
  }
  const time = date.toLocaleTimeString('en-GB', { hour: '2-digit', minute: '2-digit' });
  const midnight = new Date(today).setHours(0, 0, 0, 0) / 1000;
  if (then >= midnight - DAY && then < midnight) return `yesterday ${time}`;
  const day = { day: 'numeric', month: 'short' } as const;
  const year = date.getFullYear() === today.getFullYear() ? {} : ({ year: 'numeric' } as const);
  return date.toLocaleDateString('en-GB', { ...day, ...year });
}

/** The same in full. */
export function instantText(then: number): string {
  return new Date(then * 1000).toLocaleString('en-GB', {
    dateStyle: 'medium',
    timeStyle: 'medium',
  });
}

/** The time of day to the second: 14:03:22. */
export function clockText(then: number): string {
  return new Date(then * 1000).toLocaleTimeString('en-GB');
}

export function sizeText(bytes: number): string {
  const [size, unit] = SIZES.find(([least]) => bytes >= least) ?? [1, 'B'];
  return `${digits(bytes / size, 3)} ${unit}`;
}

/** A field that is not the shipped one: its name, then `200.3 → 312 N/mm`. */
export interface Differing {
  name: string;
  text: string;
}

export function differing({ path, shipped, value }: RunDifference): Differing {
  const variant = /^variants\.([A-Z])$/.exec(path)?.[1];
  if (variant) return { name: variant, text: value === null ? 'left out' : 'added' };
  const { unit } = fieldOf(path);
  const of = (each: unknown) => (each === null ? 'none' : show(path, each as Value));
  return { name: nameOf(path), text: `${of(shipped)} → ${of(value)} ${unit}`.trimEnd() };
}

type Stop = Pick<Run, 'stopped' | 'stopped_at'>;

/** How a run ended early, beside its name: `stopped at 4.2 s`, `fault at 4.2 s`. */
export function stopWord({ stopped, stopped_at: at }: Stop): string {
  const when = at === null || at === undefined ? '' : ` at ${at.toFixed(1)} s`;
  return `${stopped === 'STOP' ? 'stopped' : 'fault'}${when}`;
}

/** The same with its cause. */
export function stopText(run: Stop): string {
  const word = stopWord(run);
  const cause = run.stopped === 'STOP' ? ' by STOP' : `: ${pretty(run.stopped)}`;
  return `${word.charAt(0).toUpperCase()}${word.slice(1)}${cause}`;
}

/** What stands below the name of a run; `own` where no scenario of its name is shipped. */
export function summary(run: Run, own: boolean): string {
  if (run.state === 'partial') return `partial: ${pretty(run.reason)}`;
  if (run.kind === 'measurement') return 'measured';
  if (run.differences.length > 0) return '';
  if (own) return `${run.scenario}, a scenario of its own`;
  return run.name.includes(run.scenario) ? 'as shipped' : `as shipped: ${run.scenario}`;
}

/** What stands below the name of a run beside a baseline, `against` being what was set differently. */
export function againstText(run: Run, against: readonly RunDifference[] | null): string {
  if (run.state === 'partial') return `partial: ${pretty(run.reason)}`;
  if (run.kind === 'measurement') return 'measured';
  if (against === null) return `other scenario: ${run.scenario}`;
  return against.length === 0 ? 'set as the baseline' : '';
}

/** Returns when something happened, from the first sample on, s; negative: before what is recorded. */
export function timeOf(
  { tick }: Pick<RunEvent, 'tick'>,
  { first_tick: first, period }: Pick<RunDetail, 'first_tick' | 'period'>,
): number {
  return (tick - first) * period;
}

/** What happened, in a sentence without its time. */
export function eventText(event: RunEvent, period: number): string {
  const what = `${event.undo ? 'undo: ' : ''}${whatText(event, period)}`;
  if (!event.by) return what;
  const done = DONE[what];
  return done ? `${done} by ${event.by}` : `${what}, by ${event.by}`;
}

function whatText(event: RunEvent, period: number): string {
  switch (event.kind) {
    case 'change':
      return Object.entries(event.set ?? {})
        .map(([path, value]) => {
          const shipped = event.previous?.[path] ?? null;
          const { name, text } = differing({ path, shipped, value });
          return shipped === null ? `${name} ${text.replace(/^none → /, '')}` : `${name} ${text}`;
        })
        .join(', ');
    case 'push': {
      const long = digits((event.ticks ?? 0) * period * 1000, 3);
      return `push ${event.axis}, ${digits(event.force ?? 0, 3)} N for ${long} ms`;
    }
    case 'stop':
      return event.reason ? `stopped: ${pretty(event.reason)}` : STOP;
    case 'play':
      return typeof event.speed === 'number' ? `play at ${speedText(event.speed)}` : 'play';
    case 'speed':
      return `speed ${speedText(event.speed ?? 1)}`;
    case 'pause':
    case 'reset':
      return event.kind;
    case 'law':
      return lawText(event);
    case 'gap': {
      const reason = event.reason === '' ? '' : `: ${pretty(event.reason)}`;
      return `${digits((event.ticks ?? 0) * period, 3)} s are missing${reason}`;
    }
  }
}

/** What fits beside a mark on the time axis. */
export function markText(event: RunEvent): string {
  if (event.kind === 'push') return `push ${event.axis}`;
  if (event.kind === 'law') return `law ${event.law}`;
  if (event.kind !== 'change') return event.kind === 'stop' ? STOP : event.kind;
  const [first = '', ...rest] = Object.keys(event.set ?? {}).map((path) =>
    nameOf(path).replace('_', ''),
  );
  return rest.length > 0 ? `${first} +${rest.length}` : first;
}

/** Says what runs and recordings take, what of it stays, and what happens when it is full. */
export function storageText(storage: RunStorage): string {
  const { runs, size, kept_size: kept, recording_size: recording, quota } = storage;
  const count = `${runs.toLocaleString('en')} ${runs === 1 ? 'run' : 'runs'}`;
  const parts = [
    kept > 0 ? `${sizeText(kept)} of it kept or pinned` : '',
    recording > 0 ? `and ${sizeText(recording)} being recorded` : '',
  ].filter((part) => part !== '');
  return `${sizeText(size + recording)} of ${sizeText(quota)} in ${[count, ...parts].join(', ')}.`;
}

/** Says which recordings were evicted last; empty where none was. */
export function evictedText({ evicted }: RunStorage, now: number): string {
  const [latest] = evicted;
  if (!latest) return '';
  const since = evicted.filter((each) => latest.evicted - each.evicted < DAY).length;
  const others = since > 1 ? ` and ${since - 1} ${since === 2 ? 'other' : 'others'}` : '';
  return (
    `Evicted ${whenText(latest.evicted, now)}: ${latest.name}, recorded ` +
    `${whenText(latest.created, now)}${others}. Name, note, tag or pin what is to stay.`
  );
}

/** What is wrong with a search, to stand below its field; empty where it is something else. */
export function searchProblem(error: unknown): string {
  if (!(error instanceof ApiError) || error.status !== 422) return '';
  const { errors } = error.problem;
  if (!errors.every(({ loc }) => /(^|\.)q$/.test(loc))) return errorText(error);
  return errors
    .map(({ value, message, range }) => {
      const allowed = range ? ` Allowed: ${pretty(range)}.` : '';
      return `“${String(value)}” ${pretty(message)}.${allowed}`;
    })
    .join('\n');
}

/** What a search without a hit can leave out: its terms, those that are seldom met first. */
export function emptyText(query: string): string {
  return query.trim() === ''
    ? 'No runs yet. Press Play in the Lab: it is recorded from the first tick.'
    : `No run meets all of ${query.trim()}.`;
}

type First = NonNullable<Replay['first']>;

/**
 * What was compared, and what was not: the beginning of a session that went on for long has gone,
 * and is simulated without being compared.
 */
export function identicalText(
  { channels, ticks, missing }: Replay,
  { first_tick: gone, period }: Pick<RunDetail, 'first_tick' | 'period'>,
): string {
  const begun = gone > 0 ? `; the first ${durationText(gone * period)} have gone` : '';
  const rest = missing - gone;
  const without = rest > 0 ? `; ${rest.toLocaleString('en')} without a record` : '';
  return `${channels} channels, ${ticks.toLocaleString('en')} ticks${begun}${without}`;
}

/** Both values with all digits that tell them apart. */
export function differenceText({ recorded, simulated, difference, unit }: First) {
  const of = prettyUnit(unit);
  return {
    recorded: valueText(recorded, of),
    simulated: valueText(simulated, of),
    by: difference === null ? '' : `: ${digits(difference)} ${of}`.trimEnd(),
  };
}

/** How the following errors of a run have moved, those that have. */
export function movedText({ errors }: Pick<Replay, 'errors'>): string[] {
  return errors
    .filter((error) => error.max_recorded !== error.max_simulated)
    .map(({ variant, axis, max_recorded: was, max_simulated: is, max_change }) => {
      const { by, sides } = changeText(was, is, max_change);
      return `Largest error ${variant} ${axis}: ${by === '' ? '' : `${by}, `}${sides}`;
    });
}

/**
 * By how much an error has changed, and from what to what, m: `+1.25 µm`, `20.50 µm → 21.75 µm`;
 * null where a variant diverged.
 */
export function changeText(was: number | null, is: number | null, change: number | null) {
  const of = scaleOf([Math.min(was ?? Infinity, is ?? Infinity)], 'm');
  const text = (value: number | null) =>
    value === null ? 'diverged' : `${digits(value * of.factor, 4)} ${of.unit}`;
  const scale = scaleOf([change ?? 0], 'm');
  const sign = (change ?? 0) > 0 ? '+' : '';
  return {
    by: change === null ? '' : `${sign}${digits(change * scale.factor)} ${scale.unit}`,
    sides: `${text(was)} → ${text(is)}`,
  };
}

function valueText(value: number | string | null, unit: string): string {
  if (value === null) return 'missing';
  // Nine digits tell any two float32 apart.
  const text = typeof value === 'number' ? String(Number(value.toPrecision(9))) : value;
  return minus(`${text} ${unit}`.trimEnd());
}
