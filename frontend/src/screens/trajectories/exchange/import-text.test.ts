import { describe, expect, it } from 'vitest';
import { ApiError } from '../../../app/api/client';
import type { ProblemField } from '../../../app/api/types';
import type { Checked } from '../feasibility';
import { factsOf, isEdited, isWords, refusalOf, textOf } from './import-text';

function refused(some: Partial<ProblemField>): ApiError {
  const field = { loc: 'line 2', message: 'is no word that is understood', ...some };
  const errors = [field as ProblemField];
  return new ApiError({ title: '', status: 422, detail: 'refused', errors });
}

describe('a refusal', () => {
  it('names the line and shows it', () => {
    const refusal = refusalOf(refused({ value: 'Q7' }), 'G1 X1\r\n  G2 X20 Q7\r\nG1 Y1');
    expect(refusal).toEqual({
      line: 2,
      text: 'Line 2 is no word that is understood: “Q7”.',
      source: 'G2 X20 Q7',
    });
  });

  it('of an option has its value and what is allowed', () => {
    const refusal = refusalOf(
      refused({ loc: 'placement', message: 'is too far', value: 2, range: '<= 1', unit: 'm' }),
      '0,0',
    );
    expect(refusal.line).toBeNull();
    expect(refusal.text).toBe('Placement is too far: 2.000 m. Allowed: ≤ 1 m.');
  });

  it('of something else is shown unchanged', () => {
    expect(refusalOf(new Error('no answer'), '').text).toBe('no answer');
  });
});

it('tells words from files', () => {
  expect(isWords('Motion Lab')).toBe(true);
  for (const text of ['1,2', 'G1 X1', '<svg>', '…', '']) expect(isWords(text)).toBe(false);
});

it('what was read is described by size, place and feed', () => {
  const trajectory = { kind: 'path', v_max: 0.01 };
  const checked = {
    length: 0.08,
    duration: 9,
    extent: { x: [-0.01, 0.015], y: [-0.01, 0.01] },
  } as unknown as Checked;
  const imported = {
    trajectory,
    format: 'gcode',
    read: '6 lines of G-code',
    segments: 5,
    moves: 1,
    points: 7,
    corners: 4,
    deviation: 4e-12,
    notes: [],
  } as unknown as Parameters<typeof factsOf>[0];
  const facts = new Map(factsOf(imported, checked).map(({ name, value }) => [name, value]));
  expect(facts.get('timing')).toBe('feed 10.0 mm/s');
  expect(facts.get('extent')).toBe('25.0 by 20.0 mm');
  expect(facts.get('place')).toBe('x −10.0 to 15.0, y −10.0 to 10.0 mm');
  expect(facts.get('distance')).toBe('below 1 nm');
  expect(facts.get('read')).toBe('6 lines of G-code, 5 segments, 1 connecting move');
  const parts = [
    { kind: 'path', v_max: 0.02 },
    { kind: 'dwell', duration: 0.5 },
  ];
  const sequence = { ...imported, trajectory: { kind: 'sequence', parts } } as typeof imported;
  expect(factsOf(sequence, null).at(-1)?.value).toBe('feed 20.0 mm/s, 1 dwell');
  const samples = { ...imported, trajectory: { kind: 'samples' }, read: '3 samples over 2 s' };
  expect(factsOf(samples as typeof imported, null).map(({ name, value }) => [name, value])).toEqual(
    [
      ['read', '3 samples over 2 s'],
      ['timing', 'of the file, from rest'],
    ],
  );
});

it('tells a text that was changed from another one', () => {
  const star = '<svg width="20mm"><path d="M0 0 L10 0 L5 8 Z"/></svg>';
  expect(isEdited(star, star.replace('L10', 'L12'))).toBe(true);
  expect(isEdited(star, `${star}\n`)).toBe(true);
  expect(isEdited(star, 'G21 G1 X10 Y0\nG1 X0 Y0')).toBe(false);
  expect(
    isEdited(star, '<svg width="9in"><circle r="4"/><rect width="90" height="3"/></svg>'),
  ).toBe(false);
  expect(isEdited('', 'HELLO')).toBe(false);
});

it.each([
  ['UTF-8', [0x47, 0xc3, 0xb6]],
  ['UTF-8 with its mark', [0xef, 0xbb, 0xbf, 0x47, 0xc3, 0xb6]],
  ['Windows-1252', [0x47, 0xf6]],
  ['UTF-16, little-endian', [0xff, 0xfe, 0x47, 0, 0xf6, 0]],
  ['UTF-16, big-endian', [0xfe, 0xff, 0, 0x47, 0, 0xf6]],
  ['UTF-16 without its mark', [0x47, 0, 0xf6, 0]],
])('a text in %s is shown', async (_, bytes) => {
  expect(await textOf(new Blob([new Uint8Array(bytes)]))).toBe('Gö');
});
