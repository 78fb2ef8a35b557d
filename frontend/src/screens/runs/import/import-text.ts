/** A file of a measurement: what is said of it, what was found out, and what is wrong, in words. */

import { ApiError } from '../../../app/api/client';
import type { ImportDocument, ImportedColumn, ProblemField } from '../../../app/api/types';
import { errorText } from '../../../app/error-text';
import { digits, minus, pretty } from '../../../ui/units';

/** What a column becomes, as the user says. */
export interface Correction {
  channel: string;
  /** Empty for that of the header, or of the range. */
  unit: string;
}

export const KEEP = '';
export const LEAVE = '-';
const TIME = 'time';
export type Corrections = Readonly<Record<string, Correction>>;

/** Returns corrections as the server takes them: `COLUMN=CHANNEL[UNIT]`. */
export function mapOf(corrections: Corrections): string[] {
  return Object.entries(corrections).map(([column, { channel, unit }]) =>
    unit === '' || channel === KEEP || channel === LEAVE
      ? `${column}=${channel}`
      : `${column}=${channel}[${unit}]`,
  );
}

/** Fields of the form that an error can be of; a column by its header. */
const FIELDS = ['name', 'rate', 'resample', 'delimiter', 'decimal', 'align', 'offset'];

export interface Problems {
  /** Of the file as a whole. */
  file: string;
  fields: Readonly<Record<string, string>>;
  columns: Readonly<Record<string, string>>;
}

export const FINE: Problems = { file: '', fields: {}, columns: {} };

/** Returns what is wrong, by where it is to be corrected. */
export function problemsOf(error: unknown, corrections: Corrections): Problems {
  if (!(error instanceof ApiError) || error.problem.errors.length === 0) {
    return { ...FINE, file: errorText(error) };
  }
  const headers = Object.keys(corrections);
  const fields: Record<string, string> = {};
  const columns: Record<string, string> = {};
  const file: string[] = [];
  for (const problem of error.problem.errors) {
    const [, number] = /^map\.(\d+)$/.exec(problem.loc) ?? [];
    const header = number === undefined ? undefined : headers[Number(number)];
    const text = sentence(problem);
    if (header !== undefined) columns[header] = text;
    else if (FIELDS.includes(problem.loc)) fields[problem.loc] = text;
    else file.push(text);
  }
  return { file: file.join('\n'), fields, columns };
}

function sentence({ loc, message, value, range }: ProblemField): string {
  const quote = loc === 'file' && typeof value === 'string' ? ` “${value}”` : '';
  const allowed = range ? ` Allowed: ${pretty(range)}.` : '';
  const text = pretty(message).replace(/\.$/, '');
  const end = text.endsWith('?') ? '' : '.';
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}${quote && `: ${quote.trim()}`}${end}${allowed}`;
}

/** How the file is written: `csv, semicolon, decimal comma, numbers from line 2`. */
export function formText({ format, text, rows }: ImportDocument): string {
  const { delimiter, decimal, encoding, first_line: line } = text;
  const parts =
    delimiter === undefined
      ? [format]
      : [format, delimiter, `decimal ${decimal}`, encoding, `numbers from line ${line}`];
  return `${parts.join(', ')}: ${rows.toLocaleString('en')} rows`;
}

/** Findings: what was noticed, computed or left out. `grave` ones have to be corrected. */
export function findingsOf(preview: ImportDocument): { text: string; grave: boolean }[] {
  const { rate, duration, jitter, resampled } = preview;
  const plain = (text: string) => ({ text, grave: false });
  const times =
    rate === null || duration === null
      ? []
      : [
          plain(
            `${trim(rate, 6)} Hz from ${preview.rate_from}, ${trim(duration, 4)} s` +
              (jitter !== null && jitter > NOTICED
                ? `, times up to ${digits(1e6 * jitter)} µs off equal steps`
                : ''),
          ),
        ];
  const gaps = preview.gaps
    .slice(0, SHOWN)
    .map(({ start, end, samples, place }) =>
      plain(
        `${place}: ${samples} ${samples === 1 ? 'sample is' : 'samples are'} missing, ` +
          `${trim(start, 5)} to ${trim(end, 5)} s`,
      ),
    );
  const more = preview.gap_count - gaps.length;
  const missing = preview.columns
    .filter((column) => column.missing > 0)
    .map(({ column, missing: count, missing_at: place }) =>
      plain(`${column}: ${count} empty, the first at ${place}`),
    );
  return [
    ...preview.problems.map((text) => ({ text: pretty(text), grave: true })),
    ...times,
    ...(preview.merged ? [plain(mergedText(preview.merged))] : []),
    ...(resampled === null ? [] : [plain(`interpolated, the file has ${trim(resampled, 6)} Hz`)]),
    ...gaps,
    ...(more > 0 ? [plain(`${more} more gaps, ${preview.missing} samples in all`)] : []),
    ...missing,
    ...preview.derived.map((name) => plain(`${name} is computed`)),
    ...preview.notes.map((note) => plain(pretty(note))),
    ...Object.entries(preview.ignored).map(([name, why]) => plain(`${name} is not read: ${why}`)),
  ];
}

/** How the second file came onto the times of the first. */
function mergedText(merged: NonNullable<ImportDocument['merged']>): string {
  const { offset_half_width: half, drift_half_width: drift } = merged;
  const by = merged.first === '' ? '' : `, by ${merged.first} and ${merged.second}`;
  return (
    `second file: ${merged.rows} rows, offset ${trim(merged.offset, 12)} s` +
    (half === null ? '' : ` ± ${digits(1e6 * half)} µs`) +
    `, drift ${trim(1e6 * merged.drift, 4)} ppm` +
    (drift === null ? '' : ` ± ${digits(1e6 * drift)}`) +
    by
  );
}

/** A number without needless zeros. */
function trim(value: number, significant: number): string {
  return minus(String(Number(value.toPrecision(significant))));
}

/** Less is rounding of the file's times, s. */
const NOTICED = 1e-9;

/** Gaps that are listed one by one. */
const SHOWN = 5;

/** First values of a column, in the unit of the file. */
export function firstText({ first }: ImportedColumn): string {
  return first.map((value) => (value === null ? '–' : trim(value, 4))).join('  ');
}

const isTime = (column: string, corrections: Corrections) => corrections[column]?.channel === TIME;

/** The column of time of a second file: as corrected, and as guessed; empty where there is none. */
export function secondTimeOf(second: ImportDocument, corrections: Corrections) {
  const columns = second.columns.map(({ column }) => column);
  const column = columns.find((each) => isTime(each, corrections)) ?? '';
  const guessed = second.columns.find(({ channel }) => channel === TIME)?.column ?? '';
  return { columns, column, guessed, ...unitsOf(second, TIME, corrections[column]?.unit ?? '') };
}

/** Returns corrections with another column of time of the second file; without one as guessed. */
export function withTime(
  second: ImportDocument,
  corrections: Corrections,
  column: string,
  unit: string,
): Corrections {
  const columns = second.columns.map((each) => each.column);
  const others = Object.entries(corrections).filter(
    ([each]) => !(columns.includes(each) && isTime(each, corrections)),
  );
  const time = column === '' ? [] : [[column, { channel: TIME, unit }] as const];
  return Object.fromEntries([...others, ...time]);
}

/** Units that a column can have, and which of them is its present one: `um` where it says `µm`. */
export function unitsOf(preview: ImportDocument, channel: string, unit: string) {
  const known = preview.units[preview.channels[channel] ?? ''] ?? [];
  const same = known.find((each) => pretty(each) === pretty(unit));
  const units = same !== undefined || unit === '' ? [...known] : [unit, ...known];
  return { units, unit: same ?? unit };
}
