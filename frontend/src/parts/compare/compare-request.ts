/** How two runs are compared: kept in the address, sent to the server, written as a command. */

import type { RequestOf } from '../../app/api/operations';
import type { RunDetail } from '../../app/api/types';
import { clean } from '../../ui/units';

export const ALIGNS = [
  { value: 'time', name: 'time', title: 'Time of 1 with time of 2' },
  { value: 'reference', name: 'reference', title: 'Same lap and arc length of the commanded path' },
  { value: 'index', name: 'index', title: 'Sample by sample' },
] as const;
export type Align = (typeof ALIGNS)[number]['value'];

export const SAMPLES = [
  { value: 'union', name: 'samples of either' },
  { value: 'intersection', name: 'samples of both' },
] as const;
export type Samples = (typeof SAMPLES)[number]['value'];

export const INTERPOLATIONS = [
  { value: '', name: 'linear, flags hold' },
  { value: 'linear', name: 'linear' },
  { value: 'hold', name: 'hold' },
] as const;
export type Interpolation = (typeof INTERPOLATIONS)[number]['value'];

/** max(absolute, relative |1|), and how much earlier or later a value may come, SI. */
export interface Tolerance {
  absolute: number;
  relative: number;
  time: number;
}

/** What holds for the channels that fit a name or a pattern. */
export interface Rule extends Tolerance {
  interpolation: Interpolation;
}

export interface How {
  align: Align;
  /** With align time: by how much 2 is moved, s. */
  offset: number;
  samples: Samples;
  /** Times of 1 at which the comparison begins and ends, s; null for those of the overlap. */
  start: number | null;
  end: number | null;
  /** Of all channels; null where it follows from range, noise and encoder. */
  tolerance: Tolerance | null;
  /** Every channel, and equal values where there is no tolerance. */
  exact: boolean;
  rules: Readonly<Record<string, Rule>>;
  /** Names or patterns; when empty those that tell how the motion was, or all where exact. */
  only: readonly string[];
  /** Variants of 2 to those of 1 that they are compared with; others have the same letter. */
  variants: Readonly<Record<string, string>>;
}

export const NONE: Tolerance = { absolute: 0, relative: 0, time: 0 };
/** How two runs are compared at first. */
export const USUAL: How = {
  align: 'time',
  offset: 0,
  samples: 'union',
  start: null,
  end: null,
  tolerance: null,
  exact: false,
  rules: {},
  only: [],
  variants: {},
};

type Letters = [string, string];
type Stopped = Pick<RunDetail, 'events' | 'period'>;
type Body = Omit<RequestOf<'/runs/compare'>, 'a' | 'b'>;

/** Returns what is asked of the server; what is as the server has it anyway is left out. */
export function bodyOf(how: How): Body {
  const channels = Object.entries(how.rules).map(([pattern, { interpolation, ...tolerance }]) => [
    pattern,
    interpolation === '' ? tolerance : { ...tolerance, interpolation },
  ]);
  return {
    ...(how.align === 'time' ? {} : { align: how.align }),
    ...(how.offset === 0 || how.align !== 'time' ? {} : { offset: how.offset }),
    ...(how.samples === 'union' ? {} : { samples: how.samples }),
    ...(how.start === null ? {} : { start: how.start }),
    ...(how.end === null ? {} : { end: how.end }),
    ...(how.tolerance === null ? {} : { tolerance: how.tolerance }),
    ...(how.exact ? { exact: true } : {}),
    ...(channels.length === 0 ? {} : { channels: Object.fromEntries(channels) as object }),
    ...(how.only.length === 0 ? {} : { only: how.only }),
    ...(Object.keys(how.variants).length === 0 ? {} : { variants: how.variants }),
  };
}

/** Reads what `bodyOf` has written into an address; what is none is as when nothing was said. */
export function howOf(text: string): How {
  let table: unknown;
  try {
    table = JSON.parse(text);
  } catch {
    return USUAL;
  }
  if (!isTable(table)) return USUAL;
  const rules = Object.entries(tableOf(table.channels)).map(([pattern, rule]) => {
    const { interpolation } = tableOf(rule);
    return [
      pattern,
      { ...toleranceOf(rule), interpolation: choice(INTERPOLATIONS, interpolation) },
    ];
  });
  const only = Array.isArray(table.only) ? table.only : [];
  const variants = Object.entries(tableOf(table.variants)).filter((pair): pair is Letters =>
    pair.every((letter) => typeof letter === 'string' && /^[A-Z]$/.test(letter)),
  );
  return {
    align: choice(ALIGNS, table.align),
    offset: numberOf(table.offset),
    samples: choice(SAMPLES, table.samples),
    start: timeOf(table.start),
    end: timeOf(table.end),
    tolerance: isTable(table.tolerance) ? toleranceOf(table.tolerance) : null,
    exact: table.exact === true,
    rules: Object.fromEntries(rules) as How['rules'],
    only: only.filter((each): each is string => typeof each === 'string'),
    variants: Object.fromEntries(variants),
  };
}

/**
 * Returns the same comparison with 1 and 2 exchanged. Only runs aligned by time tell at which time
 * of 2 a time of 1 is; a range of others is left out.
 */
export function swapped(how: How): How {
  const moved = (time: number | null) =>
    time === null || how.align !== 'time' ? null : clean(time - how.offset);
  const variants = Object.entries(how.variants).map(([own, other]) => [other, own]);
  return {
    ...how,
    offset: 0 - how.offset,
    start: moved(how.start),
    end: moved(how.end),
    variants: Object.fromEntries(variants) as How['variants'],
  };
}

/**
 * Returns the last time of 1 before a STOP of either run, s, where runs aligned by time are compared
 * beyond it: brakes and currents that go to zero outweigh all that was before. Else null.
 */
export function lastBeforeStop(how: How, [one, two]: readonly [Stopped, Stopped]): number | null {
  if (how.align !== 'time') return null;
  const ends = [
    { run: one, later: 0 },
    { run: two, later: how.offset },
  ].flatMap(({ run, later }) => {
    const tick = run.events.find(({ kind }) => kind === 'stop')?.tick ?? 0;
    return tick > 1 ? [clean((tick - 1) * run.period + later)] : [];
  });
  const last = Math.min(...ends);
  return ends.length > 0 && last > (how.start ?? 0) && last < (how.end ?? Infinity) ? last : null;
}

/** Returns the command that gives the same verdicts. */
export function commandOf(how: How, a: string, b: string): string {
  const { tolerance, rules } = how;
  const words = ['motionlab compare', a, b];
  if (how.align !== 'time') words.push(`--align ${how.align}`);
  else if (how.offset !== 0) words.push(`--offset=${how.offset}`);
  if (how.samples !== 'union') words.push(`--samples ${how.samples}`);
  if (how.start !== null) words.push(`--from=${how.start}`);
  if (how.end !== null) words.push(`--to=${how.end}`);
  if (how.exact) words.push('--exact');
  if (tolerance) words.push(`--tolerance ${tolerance.absolute},${tolerance.relative}`);
  if (tolerance && tolerance.time !== 0) words.push(`--time-tolerance ${tolerance.time}`);
  for (const [pattern, { absolute, relative, time, interpolation }] of Object.entries(rules)) {
    words.push(`--tolerance ${quoted(`${pattern}=${absolute},${relative},${time}`)}`);
    if (interpolation !== '')
      words.push(`--interpolation ${quoted(`${pattern}=${interpolation}`)}`);
  }
  words.push(...how.only.map((pattern) => `--only ${quoted(pattern)}`));
  words.push(...Object.entries(how.variants).map((letters) => `--variant ${letters.join('=')}`));
  return words.join(' ');
}

/** Returns the request that gives the same verdicts. */
export function curlOf(how: How, a: string, b: string, origin: string): string {
  const body = JSON.stringify({ a, b, ...bodyOf(how) });
  const head = "curl -s -H 'Content-Type: application/json'";
  return `${head} -d ${quoted(body)} ${origin}/api/v1/runs/compare`;
}

/** A word for a shell. */
function quoted(text: string): string {
  return /^[\w.,=:-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`;
}

/** Patterns that a channel fits, from its name alone to all: `B.x.thrust`, `*.x.thrust`, ... */
export function patternsOf(channel: string): { value: string; name: string }[] {
  const [, axis, name] = /^(?:[A-Z]\.)?([xy])\.(.+)$/.exec(channel) ?? [];
  const own = { value: channel, name: channel };
  const all = { value: '*', name: 'every channel' };
  if (axis === undefined || name === undefined) return [own, all];
  const wider = [`*.${axis}.${name}`, `*.${name}`].filter((value) => fits(value, channel));
  return [own, ...wider.map((value) => ({ value, name: value })), all];
}

/** Whether a name fits a pattern in which `*` stands for anything. */
export function fits(pattern: string, name: string): boolean {
  const plain = pattern
    .replace(/[.+^${}()|\\]/g, '\\$&')
    .replace(/\*/g, '.*')
    .replace(/\?/g, '.');
  return new RegExp(`^${plain}$`, 's').test(name);
}

function isTable(value: unknown): value is Record<string, unknown> {
  return typeof value === 'object' && value !== null && !Array.isArray(value);
}

function tableOf(value: unknown): Record<string, unknown> {
  return isTable(value) ? value : {};
}

function numberOf(value: unknown): number {
  return typeof value === 'number' && Number.isFinite(value) ? value : 0;
}

function timeOf(value: unknown): number | null {
  return typeof value === 'number' && Number.isFinite(value) ? value : null;
}

function toleranceOf(value: unknown): Tolerance {
  const { absolute, relative, time } = tableOf(value);
  const least = (each: unknown) => Math.max(0, numberOf(each));
  return { absolute: least(absolute), relative: least(relative), time: least(time) };
}

function choice<T extends string>(options: readonly { value: T }[], value: unknown): T {
  return (options.find((option) => option.value === value) ?? (options[0] as { value: T })).value;
}
