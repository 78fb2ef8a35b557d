import { expect, it } from 'vitest';
import { cellText, csvRow } from './export';

it.each(['=1+1', '+x', '-x', '@SUM(1)', ' =x', '\t=x', '\r@x', '-2+cmd', '=1'])(
  'no spreadsheet computes %j',
  (name) => {
    expect(cellText(name)).toMatch(/^'\s?[=+\-@]/);
  },
);

it.each(['x', '-2.5', '+19.5 %', '1e-9', '-.5', '−x', "'x", '3 = 4', ''])('%j stays', (text) => {
  expect(cellText(text)).toBe(text);
});

it('numbers stay, those that are none are empty, and a text is on one line', () => {
  expect([-1e-9, 0, Number.NaN, null, undefined].map(cellText)).toEqual(['-1e-9', '0', '', '', '']);
  expect(cellText('a\r\n\tb\u0000\u001b[31mc')).toBe('a b [31mc');
  expect(csvRow(['=HYPERLINK("x","y")', 'a, "b"', -1])).toBe(
    `"'=HYPERLINK(""x"",""y"")","a, ""b""",-1`,
  );
});
