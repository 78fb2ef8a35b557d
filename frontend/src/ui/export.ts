/** What leaves the page: files, text on the clipboard, and cells of tables in both. */

/** Gives the user a file that the page made. */
export function saveFile(name: string, type: string, content: BlobPart): void {
  const address = URL.createObjectURL(new Blob([content], { type }));
  const link = document.createElement('a');
  link.href = address;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

/** Puts text on the clipboard, also where the page is not served by HTTPS. */
export async function copyText(text: string): Promise<void> {
  const { clipboard } = navigator as { clipboard?: Clipboard };
  if (clipboard) return clipboard.writeText(text);
  const area = document.createElement('textarea');
  area.value = text;
  area.style.position = 'fixed';
  document.body.append(area);
  area.select();
  const done = document.execCommand('copy');
  area.remove();
  if (!done) throw new Error('the browser does not let the page copy');
}

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
