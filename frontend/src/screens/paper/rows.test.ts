import { describe, expect, it } from 'vitest';
import type { JudgedRow, PaperKind, PaperRow } from '../../app/api/types';
import {
  bandSign,
  comesToHold,
  countOf,
  isLax,
  isOfKind,
  kindsOf,
  linesOf,
  numberOf,
  passes,
  remarkOf,
  standingOf,
  summaryOf,
  TOLD,
  unitOf,
} from './rows';

const row = (id: string, comparison: PaperRow['comparison'] = 'at_most'): PaperRow =>
  ({ id, comparison, unit: 'm', known: null }) as PaperRow;
const judged = (id: string, fields: Partial<JudgedRow>): JudgedRow =>
  ({ ...row(id), status: 'holds', holds: true, better: false, lax: '', ...fields }) as JudgedRow;

const LINES = linesOf(
  [row('a'), row('b'), row('c'), row('d', 'none'), row('e')],
  [
    judged('a', {}),
    judged('b', { better: true, lax: 'the bound is 8 times ours' }),
    judged('c', { status: 'known_failure', holds: false, known: 'so' }),
  ],
);

describe('rows', () => {
  it('stand as they were judged, and wait until they are', () => {
    expect(LINES.map(({ standing }) => standing)).toEqual([
      'holds',
      'better',
      'known_failure',
      'not_comparable',
      'waiting',
    ]);
    expect(standingOf(row('a'), judged('a', { status: 'fails', holds: false }))).toBe('fails');
  });

  it('are filtered', () => {
    const ids = (filter: Parameters<typeof passes>[1]) =>
      LINES.filter((line) => passes(line, filter)).map((line) => line.row.id);
    expect(ids('all')).toHaveLength(5);
    expect(ids('judged')).toEqual(['a', 'b', 'c', 'e']);
    expect(ids('red')).toEqual(['c']);
    expect(ids('better')).toEqual(['b']);
    expect(ids('lax')).toEqual(['b']);
    expect(ids('none')).toEqual(['d']);
  });

  it('are counted and chosen by kind', () => {
    const of = (id: string, kind: PaperRow['kind']) => ({ ...row(id), kind });
    const kinds: PaperKind[] = [
      { id: 'printed', title: 'printed value', about: '' },
      { id: 'fit', title: 'fit', about: '' },
    ];
    const lines = linesOf(
      [of('a', 'printed'), of('b', 'fit'), of('c', 'fit')],
      [
        judged('a', { kind: 'printed', status: 'fails', holds: false }),
        judged('b', { kind: 'fit' }),
      ],
    );
    expect(kindsOf(lines, kinds).map(({ id, hold, red, rest }) => [id, hold, red, rest])).toEqual([
      ['all', 1, 1, 1],
      ['printed', 0, 1, 0],
      ['fit', 1, 0, 1],
    ]);
    expect(lines.filter((line) => isOfKind(line, 'fit'))).toHaveLength(2);
    expect(lines.filter((line) => isOfKind(line, 'all'))).toHaveLength(3);
  });

  it('say of what kind they are, and that they are lax', () => {
    const of = (kind: PaperRow['kind'], lax: string) => {
      const judgedRow = judged('a', { kind, lax });
      return { row: judgedRow, judged: judgedRow, standing: 'holds' as const };
    };
    expect(remarkOf(of('printed', ''), 'printed value')).toBe('');
    expect(remarkOf(of('printed', 'why'), 'printed value')).toBe('weak test');
    expect(remarkOf(of('claim', 'why'), 'claim')).toBe('claim, weak test');
    expect(LINES.filter((line) => isLax(line.judged)).map((line) => line.row.id)).toEqual(['b']);
  });

  it('are red too when a known failure has come to hold', () => {
    const mended = judged('a', { known: 'never' });
    expect(comesToHold(mended)).toBe(true);
    expect(passes({ row: row('a'), judged: mended, standing: 'holds' }, 'red')).toBe(true);
    expect(comesToHold(judged('a', {}))).toBe(false);
  });

  it('are counted', () => {
    expect(countOf(LINES)).toMatchObject({ holds: 1, better: 1, known_failure: 1, waiting: 1 });
    expect(summaryOf(LINES)).toBe('2 hold, 0 fail, 1 known failures, 1 not comparable');
    expect(summaryOf(linesOf([row('a')], []))).toBe('nothing computed yet');
  });

  it('tell each state by an icon and a word of its own', () => {
    const looks = Object.values(TOLD);
    expect(new Set(looks.map(({ word }) => word)).size).toBe(looks.length);
    for (const { icon } of looks) expect(icon).not.toBe('');
  });
});

describe('numbers', () => {
  it('have four digits, three and one prefix for both ends of a range', () => {
    expect(numberOf(2.0513e-5, 'm')).toEqual({ number: '20.51', unit: 'µm' });
    expect(numberOf([-14.2e-6, 8.329e-6], 'm')).toEqual({ number: '−14.2 … 8.33', unit: 'µm' });
    expect(numberOf(145, '1')).toEqual({ number: '145', unit: '' });
    expect(numberOf(0, 'm')).toEqual({ number: '0', unit: 'm' });
    expect(numberOf(null, 'm').number).toBe('–');
    expect(numberOf(1.29e-12, 'm^4')).toEqual({ number: '1.29e−12', unit: 'm⁴' });
  });

  it('are per cent where the paper prints per cent', () => {
    expect(unitOf({ unit: '1', printed: '72.5 %' })).toBe('%');
    expect(unitOf({ unit: '1', printed: '145 turns' })).toBe('1');
    expect(numberOf(0.725, '%')).toEqual({ number: '72.5', unit: '%' });
    expect(numberOf([0.0003, 0.1111], '%')).toEqual({ number: '0.03 … 11.11', unit: '%' });
  });

  it('say what a band does to a bound', () => {
    expect([bandSign('at_most'), bandSign('at_least'), bandSign('within')]).toEqual([
      '+',
      '−',
      '±',
    ]);
  });
});
