/** What was read of a file, and what is wrong with it, in words. */

import { ApiError } from '../../../app/api/client';
import type { ProblemField } from '../../../app/api/types';
import { errorText } from '../../../app/error-text';
import { digits, pretty, quantity } from '../../../ui/units';
import type { Checked } from '../feasibility';
import { withUnit } from '../feasibility';
import type { FileFormat, ReadFile } from './exchange-api';

export const FORMATS: Readonly<Record<FileFormat, string>> = {
  auto: 'as found',
  csv: 'CSV',
  svg: 'SVG',
  gcode: 'G-code',
  text: 'Text to write',
};

/** Longest part of a refused line that is shown. */
const SHOWN = 80;

export interface Refusal {
  /** Line of the file, from 1; null where the file as a whole or an option is refused. */
  line: number | null;
  text: string;
  /** The line itself, as far as it is shown. */
  source: string;
}

/** Returns why a file was refused, and the line that it is about. */
export function refusalOf(error: unknown, content: string): Refusal {
  const [problem] = error instanceof ApiError ? error.problem.errors : [];
  if (!problem) return { line: null, text: errorText(error), source: '' };
  const [, number] = /^line (\d+)$/.exec(problem.loc) ?? [];
  const line = number === undefined ? null : Number(number);
  const whole = line === null ? '' : (content.split(/\r\n|\r|\n/)[line - 1] ?? '').trim();
  const source = whole.length > SHOWN ? `${whole.slice(0, SHOWN)}…` : whole;
  return { line, text: sentence(problem, line), source };
}

function sentence({ loc, message, value, range, unit }: ProblemField, line: number | null): string {
  const where = line === null ? (loc === 'file' ? 'The file' : loc) : `Line ${line}`;
  const got =
    typeof value === 'string' && value !== ''
      ? `: “${value}”`
      : typeof value === 'number'
        ? `: ${digits(value, 4)} ${unit ?? ''}`.trimEnd()
        : '';
  const allowed = range
    ? ` Allowed: ${pretty(range).replace('<=', '≤').replace('>=', '≥')} ${unit ?? ''}`.trimEnd() +
      '.'
    : '';
  const text = pretty(message).replace(/\.$/, '');
  return `${where.charAt(0).toUpperCase()}${where.slice(1)} ${text}${got}.${allowed}`;
}

/** Returns whether a text without any digit is rather to be written than read as a file. */
export function isWords(text: string): boolean {
  return /\p{L}/u.test(text) && !/[\d<]/.test(text);
}

/** Whether a text is another one with changes: most of the shorter one is as it was. */
export function isEdited(before: string, after: string): boolean {
  const shorter = Math.min(before.length, after.length);
  let same = 0;
  while (same < shorter && before[same] === after[same]) same++;
  let end = 0;
  while (end < shorter - same && before.at(-1 - end) === after.at(-1 - end)) end++;
  return 2 * (same + end) > shorter;
}

export interface Fact {
  name: string;
  value: string;
  title: string;
}

/** What a file has become: size, place and timing. */
export function factsOf(imported: ReadFile, checked: Checked | null): Fact[] {
  const facts: Fact[] =
    imported.trajectory.kind === 'samples' ? sampleFacts(imported) : pathFacts(imported);
  if (!checked) return facts;
  return [
    ...facts,
    { name: 'length', value: withUnit(checked.length, 'm'), title: 'Once along the path' },
    { name: 'extent', value: extentText(checked), title: 'Width by height' },
    { name: 'place', value: placeText(checked), title: 'On the stroke, from its middle' },
    { name: 'duration', value: withUnit(checked.duration, 's'), title: 'Of the whole motion' },
  ];
}

function sampleFacts({ read }: ReadFile): Fact[] {
  return [
    { name: 'read', value: read, title: 'What the file has' },
    {
      name: 'timing',
      value: 'of the file, from rest',
      title: 'Between samples the cubic spline through all of them',
    },
  ];
}

function pathFacts(imported: ReadFile): Fact[] {
  return [
    { name: 'read', value: readText(imported), title: 'What the file has' },
    {
      name: 'path',
      value: `${count(imported.points, 'point')}, ${count(imported.corners, 'corner')}`,
      title: 'The path stops at its corners',
    },
    {
      name: 'distance',
      value: imported.deviation < 1e-9 ? 'below 1 nm' : withUnit(imported.deviation, 'm'),
      title: 'Largest distance of the path from the file',
    },
    { name: 'timing', value: timingText(imported.trajectory), title: 'Of the motion profile' },
  ];
}

function count(number: number, what: string): string {
  return `${number} ${what}${number === 1 ? '' : 's'}`;
}

function readText({ read, segments, moves }: ReadFile): string {
  const between = moves > 0 ? `, ${count(moves, 'connecting move')}` : '';
  return /segment/.test(read) ? read : `${read}, ${count(segments, 'segment')}${between}`;
}

/** Returns the feed, or the time of a lap, of a path or of the parts of a sequence. */
function timingText(trajectory: ReadFile['trajectory']): string {
  const table = trajectory as Record<string, unknown>;
  const parts = Array.isArray(table.parts) ? (table.parts as Record<string, unknown>[]) : [table];
  const of = (key: string) =>
    parts.map((part) => part[key]).filter((value) => typeof value === 'number');
  const [lap] = of('lap_time');
  if (lap !== undefined) return `${withUnit(lap, 's')} a lap, of the file`;
  const speeds = of('v_max');
  const dwells = of('duration');
  const [dwell] = of('dwell');
  const feed = speeds.length > 0 ? withUnit(Math.max(...speeds), 'm/s') : '–';
  const rests =
    dwells.length > 0
      ? `, ${count(dwells.length, 'dwell')}`
      : dwell
        ? `, ${withUnit(dwell, 's')} dwell at each stop`
        : '';
  return `feed ${feed}${rests}`;
}

function extentText({ extent }: Checked): string {
  const [x, y] = [extent.x, extent.y].map(([low, high]) => mm(high - low));
  return `${x} by ${y} mm`;
}

function placeText({ extent }: Checked): string {
  const [x, y] = [extent.x, extent.y].map(([low, high]) => `${mm(low)} to ${mm(high)}`);
  return `x ${x}, y ${y} mm`;
}

function mm(metres: number): string {
  const { number, unit } = quantity(metres, 'm');
  return unit === 'mm' ? number : digits(Number((metres * 1e3).toFixed(4)), 4);
}

/** Text of a file for people: the server reads its bytes, this only shows them. */
export async function textOf(file: Blob): Promise<string> {
  const bytes = new Uint8Array(await file.arrayBuffer());
  try {
    return new TextDecoder(wide(bytes) ?? 'utf-8', { fatal: true }).decode(bytes);
  } catch {
    return new TextDecoder('windows-1252').decode(bytes);
  }
}

/** UTF-16, by its mark or by where the zeros stand. */
function wide(bytes: Uint8Array): string | null {
  const [first = 1, second = 1] = bytes;
  if ((first === 0xfe && second === 0xff) || (first === 0 && second !== 0)) return 'utf-16be';
  if ((first === 0xff && second === 0xfe) || (first !== 0 && second === 0)) return 'utf-16le';
  return null;
}
