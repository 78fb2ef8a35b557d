/** The search over runs as text: views, filters and the field share its terms; docs/runs.md. */

/** One term as it is typed: quotes around it, or after its colon, keep blanks together. */
const TERM = /(?:[a-z]+:)?(["']).*?\1(?=\s|$)|\S+/g;
const QUOTED = /^([a-z]+:)?(["'])(.*)\2$/;
const WEEK = 7 * 24 * 3600 * 1000;

export type ViewId = 'all' | 'pinned' | 'week' | 'measurements' | 'partial' | 'deleted';

export interface QuickView {
  id: ViewId;
  name: string;
  title: string;
  term: string;
}

/** Returns the quick views; the term of a week depends on the day. */
export function viewsAt(now: number): readonly QuickView[] {
  const day = new Date(now - WEEK).toISOString().slice(0, 10);
  return [
    { id: 'all', name: 'All', title: 'All runs', term: '' },
    { id: 'pinned', name: 'Pinned', title: 'Never evicted', term: 'is:pinned' },
    { id: 'week', name: 'This week', title: 'Of the last seven days', term: `after:${day}` },
    { id: 'measurements', name: 'Measurements', title: 'Imported', term: 'kind:measurement' },
    { id: 'partial', name: 'Partial', title: 'Recorded in part', term: 'state:partial' },
    { id: 'deleted', name: 'Deleted', title: 'Can be restored for a while', term: 'is:deleted' },
  ];
}

/** Returns the terms of a search without their quotes. */
export function termsOf(query: string): string[] {
  return (query.match(TERM) ?? []).map(plain);
}

export function hasTerm(query: string, term: string): boolean {
  return termsOf(query).includes(term);
}

/** Returns the search with a term added at its end, or without it if it was there. */
export function toggled(query: string, term: string): string {
  return hasTerm(query, term) ? without(query, [term]) : joined([query.trim(), quoted(term)]);
}

/** Returns the search with another quick view and all its other terms. */
export function withView(query: string, view: QuickView, views: readonly QuickView[]): string {
  const rest = without(
    query,
    views.map(({ term }) => term),
  );
  return joined([view.term, rest]);
}

/** Returns the quick view that a search is of. */
export function viewOf(query: string, views: readonly QuickView[]): ViewId {
  const terms = termsOf(query);
  return views.find(({ term }) => term !== '' && terms.includes(term))?.id ?? 'all';
}

/** Ends of what a metric may be, SI; null where it has none. */
export interface Bounds {
  low: number | null;
  high: number | null;
}

const BOUND = /^([A-Z]\.[xy]\.[a-z_]+)([<>])=?([-+0-9.eE]+?)(µm|um|mm|nm|ms|mN|m|s|N|dB|deg|rad)?$/;
const SIZES: Readonly<Record<string, number>> = {
  mm: 1e-3,
  um: 1e-6,
  µm: 1e-6,
  nm: 1e-9,
  ms: 1e-3,
  mN: 1e-3,
  deg: Math.PI / 180,
};

/** A unit as it is typed. */
const TYPED: Readonly<Record<string, string>> = { µm: 'um', '°': 'deg' };

/** Returns the bounds of a metric, such as `B.x.max`, in a search. */
export function boundsOf(query: string, metric: string): Bounds {
  const bounds: Bounds = { low: null, high: null };
  for (const term of termsOf(query)) {
    const [, name, sign, number, unit = ''] = BOUND.exec(term) ?? [];
    if (name !== metric) continue;
    bounds[sign === '>' ? 'low' : 'high'] =
      unit === 'dB' ? 10 ** (Number(number) / 20) : Number(number) * (SIZES[unit] ?? 1);
  }
  return bounds;
}

/** Returns the search with these bounds of a metric, in its unit. */
export function withBounds(
  query: string,
  metric: string,
  { low, high }: Bounds,
  { unit, shown }: { unit: string; shown: (value: number) => number },
): string {
  const others = (query.match(TERM) ?? []).filter(
    (term) => BOUND.exec(plain(term))?.[1] !== metric,
  );
  const written = (sign: string, value: number | null) =>
    value === null
      ? ''
      : `${metric}${sign}${Number(shown(value).toPrecision(3))}${TYPED[unit] ?? unit}`;
  return joined([...others, written('>', low), written('<', high)]);
}

function without(query: string, terms: readonly string[]): string {
  return joined((query.match(TERM) ?? []).filter((term) => !terms.includes(plain(term))));
}

function joined(parts: readonly string[]): string {
  return parts.filter((part) => part !== '').join(' ');
}

function plain(term: string): string {
  return term.replace(QUOTED, '$1$3');
}

function quoted(term: string): string {
  if (!/\s/.test(term)) return term;
  return term.includes('"') ? `'${term}'` : `"${term}"`;
}
