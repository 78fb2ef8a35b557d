/** The document of a view of one's own as tables: records with the same figures stand side by side. */

import type { OwnView } from './own-views.svelte';
import { row, type Row } from './rows';

export interface OwnTable {
  heads: readonly { name: string; variant?: string }[];
  rows: readonly Row[];
}

type Value = number | string | boolean | null;

interface Entry {
  path: readonly string[];
  values: Readonly<Record<string, Value>>;
}

/** Most columns of a table; further records are left to the command and to REST. */
const COLUMNS_MAX = 12;

const isTable = (value: unknown): value is Record<string, unknown> =>
  typeof value === 'object' && value !== null && !Array.isArray(value);

function* records(value: unknown, path: readonly string[]): Generator<Entry> {
  if (Array.isArray(value)) {
    for (const [at, item] of value.entries()) yield* records(item, [...path, String(at + 1)]);
  } else if (isTable(value)) {
    const parts = Object.entries(value);
    const own = parts.filter(([, part]) => !isTable(part) && !isList(part));
    if (own.length > 0) yield { path, values: Object.fromEntries(own.map(cell)) };
    for (const [name, part] of parts) {
      if (isTable(part) || isList(part)) yield* records(part, [...path, name]);
    }
  }
}

/** Whether a value is a list of tables; one of numbers is a cell that counts them. */
const isList = (value: unknown): value is unknown[] => Array.isArray(value) && value.some(isTable);

const cell = ([name, value]: [string, unknown]): [string, Value] => [
  name,
  Array.isArray(value) ? `${value.length.toString()} values` : (value as Value),
];

/** What tells a record from the others of its table: its path without the name of the mapping. */
function headOf(path: readonly string[], variants: readonly string[]): OwnTable['heads'][number] {
  const name = (path.length > 1 ? path.slice(1) : path).join(' ').replaceAll('_', ' ');
  const variant = path.find((part) => variants.includes(part));
  return variant === undefined ? { name } : { name, variant };
}

/** Returns the tables of a document. */
export function ownTables(
  document: unknown,
  figures: OwnView['figures'],
  variants: readonly string[],
): OwnTable[] {
  const alike = new Map<string, Entry[]>();
  for (const entry of records(document, [])) {
    const key = Object.keys(entry.values).join(' ');
    alike.set(key, [...(alike.get(key) ?? []), entry]);
  }
  return [...alike.values()].map((all) => {
    const shown = all.slice(0, COLUMNS_MAX);
    const rows = Object.keys(shown[0]?.values ?? {}).map((name) => {
      const { unit = '', description = '' } = figures[name] ?? {};
      return rowOf(
        name.replaceAll('_', ' '),
        description,
        unit,
        shown.map((one) => one.values[name] ?? null),
      );
    });
    return { heads: shown.map(({ path }) => headOf(path, variants)), rows };
  });
}

function rowOf(name: string, title: string, unit: string, values: readonly Value[]): Row {
  const numbers = values.filter((value) => typeof value === 'number' || value === null);
  if (numbers.length === values.length) return row(name, title, unit, numbers as (number | null)[]);
  return {
    name,
    title,
    unit: '',
    cells: values.map((value) => (value === null ? '–' : String(value))),
  };
}
