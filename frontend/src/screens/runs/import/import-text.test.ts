import { expect, it } from 'vitest';
import { ApiError } from '../../../app/api/client';
import type { ImportDocument } from '../../../app/api/types';
import {
  findingsOf,
  formText,
  mapOf,
  problemsOf,
  secondTimeOf,
  unitsOf,
  withTime,
} from './import-text';

const CORRECTIONS = {
  'Pos [um]': { channel: 'M.x.position_measured', unit: 'mm' },
  Temp: { channel: '-', unit: '' },
  Own: { channel: '', unit: 'm' },
};

it('corrections are as the server takes them', () => {
  expect(mapOf(CORRECTIONS)).toEqual(['Pos [um]=M.x.position_measured[mm]', 'Temp=-', 'Own=']);
});

it('what is wrong stands where it is to be corrected', () => {
  const refused = (...errors: object[]) =>
    new ApiError({ title: '', status: 422, detail: '', errors: errors as never });
  const problems = problemsOf(
    refused(
      {
        loc: 'file',
        message: "line 4, column 'x': is no finite number (decimal point)",
        value: '1,5',
      },
      { loc: 'map.1', message: 'has another unit', value: 'A', range: 'a unit of x' },
      { loc: 'rate', message: 'is out of range' },
    ),
    CORRECTIONS,
  );
  expect(problems.file).toBe("Line 4, column 'x': is no finite number (decimal point): “1,5”.");
  expect(problems.columns).toEqual({ Temp: 'Has another unit. Allowed: a unit of x.' });
  expect(problems.fields).toEqual({ rate: 'Is out of range.' });
  expect(problemsOf(new Error('lost'), {}).file).toBe('lost');
});

const FOUND = {
  format: 'csv',
  text: { delimiter: 'semicolon', decimal: 'comma', encoding: 'utf-8', first_line: 2 },
  rows: 3,
  columns: [{ column: 'x', missing: 2, missing_at: 'line 12' }],
  ignored: { Note: 'is text' },
  rate: 1000,
  rate_from: 'Zeit',
  duration: 0.005,
  jitter: 0,
  gaps: [{ start: 0.001, end: 0.004, samples: 2, place: 'line 4' }],
  gap_count: 3,
  missing: 7,
  resampled: null,
  derived: ['M.x.following_error'],
  problems: ['give the rate'],
  notes: ['line 1 is passed over'],
  channels: { time: 's', 'x.position_reference': 'm' },
  units: { s: ['s', 'ms'], m: ['m', 'mm', 'um'] },
} as unknown as ImportDocument;

it('findings name line and column, what has to be corrected first', () => {
  expect(formText(FOUND)).toBe('csv, semicolon, decimal comma, utf-8, numbers from line 2: 3 rows');
  expect(findingsOf(FOUND).map(({ text }) => text)).toEqual([
    'give the rate',
    '1000 Hz from Zeit, 0.005 s',
    'line 4: 2 samples are missing, 0.001 to 0.004 s',
    '2 more gaps, 7 samples in all',
    'x: 2 empty, the first at line 12',
    'M.x.following_error is computed',
    'line 1 is passed over',
    'Note is not read: is text',
  ]);
  expect(findingsOf(FOUND)[0]?.grave).toBe(true);
});

it('a unit that is not listed stays to choose', () => {
  expect(unitsOf(FOUND, 'x.position_reference', 'µm')).toEqual({
    units: ['m', 'mm', 'um'],
    unit: 'um',
  });
  expect(unitsOf(FOUND, 'time', 'h').units).toEqual(['h', 's', 'ms']);
  expect(unitsOf(FOUND, 'time', 'ms')).toEqual({ units: ['s', 'ms'], unit: 'ms' });
});

it('the time of a second file is one of its columns, as guessed or as corrected', () => {
  const columns = [
    { column: 'Channel name', channel: '' },
    { column: 'Force', channel: 'M.x.thrust' },
  ];
  const second = { ...FOUND, columns } as unknown as ImportDocument;
  expect(secondTimeOf(second, CORRECTIONS)).toMatchObject({ column: '', guessed: '' });
  const guessed = { ...second, columns: [{ column: 't', channel: 'time' }] } as typeof second;
  expect(secondTimeOf(guessed, {})).toMatchObject({ column: '', guessed: 't' });

  const one = withTime(second, CORRECTIONS, 'Channel name', 'ms');
  expect(mapOf(one).at(-1)).toBe('Channel name=time[ms]');
  expect(secondTimeOf(second, one)).toMatchObject({ column: 'Channel name', unit: 'ms' });
  const other = withTime(second, one, 'Force', '');
  expect(Object.keys(other)).toEqual([...Object.keys(CORRECTIONS), 'Force']);
  expect(withTime(second, other, '', '')).toEqual(CORRECTIONS);
  // the first file's own time stays
  const first = { ms: { channel: 'time', unit: 'ms' } };
  expect(withTime(second, first, 'Force', '')).toMatchObject(first);
});
