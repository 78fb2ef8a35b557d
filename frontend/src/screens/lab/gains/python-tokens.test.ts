import { expect, it } from 'vitest';
import { pythonLines } from './python-tokens';

const parts = (source: string) =>
  pythonLines(source).map((line) =>
    line.filter(({ kind }) => kind !== '').map(({ kind, text }) => `${kind} ${text}`),
  );

it('keeps every sign of a text, line by line', () => {
  const source = `a = """one\n\n  # two"""  # three\nif x1 != .5e-3:\n\treturn "é\\"", f'{a}'`;
  const lines = pythonLines(source).map((line) => line.map(({ text }) => text).join(''));
  expect(lines.join('\n')).toBe(source);
  expect(pythonLines('a\n')).toHaveLength(1);
});

it('tells strings, comments, numbers, keywords and decorators apart', () => {
  expect(parts('x = "# no" # "yes"')).toEqual([['string "# no"', 'comment # "yes"']]);
  expect(parts("y = rb'it' if v_2 > 1_0.5e-3 else 0xfF")).toEqual([
    ["string rb'it'", 'keyword if', 'number 1_0.5e-3', 'keyword else', 'number 0xfF'],
  ]);
  expect(parts('@compiled\ndef iffy(a): # b\n  c = a @ d')).toEqual([
    ['decorator @compiled'],
    ['keyword def', 'comment # b'],
    [],
  ]);
});

it('a string goes on over lines with three quotes, and ends with its line with one', () => {
  expect(parts('"""a\nif"""; b = "open\nif')).toEqual([
    ['string """a'],
    ['string if"""', 'string "open'],
    ['keyword if'],
  ]);
  expect(parts("'''never\nif")).toEqual([["string '''never"], ['string if']]);
});
