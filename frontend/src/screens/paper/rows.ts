/** Rows of the paper's numbers: merged with what was computed, counted, filtered, put in words. */

import type { JudgedRow, PaperKind, PaperRow } from '../../app/api/types';
import { digits, minus, prettyUnit, scaleFor, type Quantity } from '../../ui/units';

export type RowState = JudgedRow['status'] | 'better' | 'waiting';
export type Filter = 'all' | 'judged' | 'red' | 'better' | 'lax' | 'none';
export type KindFilter = PaperKind['id'] | 'all';
export type PrintedRange = number | readonly number[] | null;

/** A row and what was computed for it, if anything was. */
export interface PaperLine {
  row: PaperRow;
  judged: JudgedRow | null;
  standing: RowState;
}

interface Told {
  icon: string;
  word: string;
  ink: 'good' | 'bad' | 'muted';
}

/** Icon, word and colour together: a status never depends on one of them alone. */
export const TOLD: Readonly<Record<RowState, Told>> = {
  holds: { icon: '✓', word: 'holds', ink: 'good' },
  better: { icon: '✓', word: 'better', ink: 'good' },
  fails: { icon: '✗', word: 'fails', ink: 'bad' },
  known_failure: { icon: '✗', word: 'known failure', ink: 'bad' },
  not_comparable: { icon: '–', word: 'not comparable', ink: 'muted' },
  waiting: { icon: '○', word: 'not computed', ink: 'muted' },
};

export const FILTERS: readonly { value: Filter; name: string; title: string }[] = [
  { value: 'all', name: 'All', title: 'Every number that the paper prints' },
  { value: 'judged', name: 'Judged', title: 'Without what cannot be compared' },
  { value: 'red', name: 'Red', title: 'Failures, known ones among them' },
  { value: 'better', name: 'Better', title: 'Ours stays well inside of a bound' },
  {
    value: 'lax',
    name: 'Weak',
    title: 'Weak tests: rows that hold, but would with nearly any model',
  },
  {
    value: 'none',
    name: 'Unjudged',
    title: 'Not comparable: what the text gives no way to compute',
  },
];

export function standingOf(row: PaperRow, judged: JudgedRow | null): RowState {
  if (row.comparison === 'none') return 'not_comparable';
  if (!judged) return 'waiting';
  return judged.status === 'holds' && judged.better ? 'better' : judged.status;
}

export function linesOf(rows: readonly PaperRow[], judged: readonly JudgedRow[]): PaperLine[] {
  const byId = new Map(judged.map((row) => [row.id, row]));
  return rows.map((row) => {
    const computed = byId.get(row.id) ?? null;
    return { row: computed ?? row, judged: computed, standing: standingOf(row, computed) };
  });
}

export function passes({ standing, judged }: PaperLine, filter: Filter): boolean {
  switch (filter) {
    case 'all':
      return true;
    case 'judged':
      return standing !== 'not_comparable';
    case 'red':
      return standing === 'fails' || standing === 'known_failure' || comesToHold(judged);
    case 'better':
      return standing === 'better';
    case 'lax':
      return isLax(judged);
    case 'none':
      return standing === 'not_comparable';
  }
}

export function isOfKind({ row }: PaperLine, kind: KindFilter): boolean {
  return kind === 'all' || row.kind === kind;
}

/** Nearly any model would satisfy it; the reason is the row's `lax`. */
export function isLax(judged: JudgedRow | null): boolean {
  return judged !== null && judged.lax !== '';
}

/** Remark below a row's status: its kind, unless it is the plain one, and whether it is a weak test. */
export function remarkOf({ row, judged }: PaperLine, title: string): string {
  const kind = row.kind === 'printed' ? [] : [title];
  return [...kind, ...(isLax(judged) ? ['weak test'] : [])].join(', ');
}

/** Rows of a kind: how many hold, how many are red, and how many are neither. */
export interface KindCount {
  id: KindFilter;
  title: string;
  about: string;
  hold: number;
  red: number;
  rest: number;
}

/** All rows, and those of each kind, counted: agreement is evidence for some kinds only. */
export function kindsOf(lines: readonly PaperLine[], kinds: readonly PaperKind[]): KindCount[] {
  const all = {
    id: 'all',
    title: 'all rows',
    about: 'Every number that the paper prints',
  } as const;
  return [all, ...kinds].map((kind) => {
    const counts = countOf(lines.filter((line) => isOfKind(line, kind.id)));
    return {
      ...kind,
      hold: counts.holds + counts.better,
      red: counts.fails + counts.known_failure,
      rest: counts.not_comparable + counts.waiting,
    };
  });
}

/** A known failure that holds is an error of the page that names it. */
export function comesToHold(judged: JudgedRow | null): boolean {
  return judged !== null && judged.holds === true && judged.known !== null;
}

export function countOf(lines: readonly PaperLine[]): Record<RowState, number> {
  const counts = {
    holds: 0,
    better: 0,
    fails: 0,
    known_failure: 0,
    not_comparable: 0,
    waiting: 0,
  };
  for (const { standing } of lines) counts[standing] += 1;
  return counts;
}

/** The unit a row is shown in: a share that the paper prints in per cent stays so. */
export function unitOf(row: Pick<PaperRow, 'unit' | 'printed'>): string {
  return row.unit === '1' && row.printed.includes('%') ? '%' : row.unit;
}

/**
 * Writes a number with four digits, or both ends of a range, in one unit; a band in that of what it is
 * `about`.
 */
export function numberOf(
  value: PrintedRange | undefined,
  unit: string,
  significant = 4,
  about: PrintedRange = null,
): Quantity {
  if (value === null || value === undefined) return { number: '–', unit: '' };
  const ends = typeof value === 'number' ? [value] : value;
  if (unit === '%') {
    return {
      number: ends.map((end) => minus(String(rounded(100 * end, significant)))).join(' … '),
      unit: '%',
    };
  }
  const size = Math.max(...ends.map(Math.abs));
  if (size === 0) return { number: '0', unit: prettyUnit(unit) };
  const like = Math.max(...[about ?? 0].flat().map(Math.abs)) || size;
  const scale = scaleFor(like, unit);
  // Two numbers in one place: three digits each.
  const most = ends.length > 1 ? Math.min(significant, 3) : significant;
  const texts = ends.map((end) => short(end * scale.factor, most));
  return { number: texts.join(' … '), unit: scale.unit };
}

function rounded(value: number, significant: number): number {
  return Number(value.toPrecision(significant));
}

function short(value: number, significant: number): string {
  if (value === 0 || Math.abs(value) < 1e-12) return '0';
  const size = Math.abs(value);
  return size >= 1e6 || size < 1e-3 ? digits(value, 3) : minus(String(rounded(value, significant)));
}

/** The sign in front of a band: what it does to a bound. */
export function bandSign(comparison: PaperRow['comparison']): string {
  if (comparison === 'at_most') return '+';
  return comparison === 'at_least' ? '−' : '±';
}

const COMPARED: Readonly<Record<PaperRow['comparison'], string>> = {
  value: 'within the band of it',
  at_most: 'a bound from above: no more than the band beyond it',
  at_least: 'a bound from below: no more than the band short of it',
  within: 'a range: no more than the band outside of it',
  none: 'not compared',
};

export function comparedAs(comparison: PaperRow['comparison']): string {
  return COMPARED[comparison];
}

/** Screen reader's summary of a run. */
export function summaryOf(lines: readonly PaperLine[]): string {
  const counts = countOf(lines);
  const done = lines.length - counts.waiting - counts.not_comparable;
  if (done === 0) return 'nothing computed yet';
  return [
    `${(counts.holds + counts.better).toString()} hold`,
    `${counts.fails.toString()} fail`,
    `${counts.known_failure.toString()} known failures`,
    `${counts.not_comparable.toString()} not comparable`,
  ].join(', ');
}
