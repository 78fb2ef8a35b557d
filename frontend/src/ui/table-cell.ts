/** Cells of text tables, for files and the clipboard. */

/** Signs with which a spreadsheet begins a formula, also behind blanks. */
const FORMULA = /^\s*[=+\-@]/;
const NUMBER = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?( ?%)?$/i;
// eslint-disable-next-line no-control-regex -- which have no place in a name
const CONTROLS = /[\u0000-\u001f\u007f-\u009f]+/g;

/**
 * Returns what stands in a cell: numbers as they are, text on one line and such that no spreadsheet
 * computes it, as in the server's files: with an apostrophe before a formula's sign.
 */
export function cellText(cell: unknown): string {
  if (typeof cell === 'number') return Number.isFinite(cell) ? String(cell) : '';
  const text = String(cell ?? '').replace(CONTROLS, ' ');
  return FORMULA.test(text) && !NUMBER.test(text) ? `'${text}` : text;
}

/** Returns a row of CSV without its end. */
export function csvRow(cells: readonly unknown[]): string {
  return cells.map((cell) => quoted(cellText(cell))).join();
}

function quoted(text: string): string {
  return /[",]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
