/** A layout of scopes: which channels each draws, and how; as a text that links, browser and server keep. */

export interface ScopeSpec {
  /** Columns, in the order of the legend. */
  channels: readonly string[];
  /** Those whose curve is hidden. */
  hidden: readonly string[];
  /** Those with a value axis of their own. */
  own: readonly string[];
  /** Height as a share of that of others. */
  size: number;
  /** Ends of the value axis; without them it follows the data. */
  hold: readonly [number, number] | null;
}

/** Most scopes of a layout, and traces of a scope. */
export const SCOPES_MAX = 12;
export const TRACES_MAX = 16;
const SIZE = { least: 0.25, most: 8 };
const TEXT_MAX = 6000;

export function scopeWith(...channels: string[]): ScopeSpec {
  return { channels, hidden: [], own: [], size: 1, hold: null };
}

/**
 * Writes a layout: scopes parted by `;`, their channels by `,`. A channel ends with `!` where it is
 * hidden and with `~` where it has a value axis of its own; a scope with `@` and its size, and with
 * `=` and the ends of its value axis, `from:to`, where they differ from the usual.
 */
export function layoutText(scopes: readonly ScopeSpec[]): string {
  return scopes.map(scopeText).join(';');
}

export function scopeText({ channels, hidden, own, size, hold }: ScopeSpec): string {
  const names = channels.map(
    (name) => `${escaped(name)}${hidden.includes(name) ? '!' : ''}${own.includes(name) ? '~' : ''}`,
  );
  const high = size === 1 ? '' : `@${Number(size.toPrecision(3))}`;
  const ends = hold ? `=${hold.map((end) => Number(end.toPrecision(6))).join(':')}` : '';
  return `${names.join(',')}${high}${ends}`;
}

/** Reads a layout; null where the text is none. */
export function readLayout(text: string): ScopeSpec[] | null {
  if (text === '' || text.length > TEXT_MAX) return null;
  const scopes = text.split(';').map(readScope);
  if (scopes.length > SCOPES_MAX || scopes.includes(null)) return null;
  return scopes as ScopeSpec[];
}

const SCOPE = /^([^@=]+)(?:@([\d.]+))?(?:=(-?[\d.e+-]+):(-?[\d.e+-]+))?$/;
const CHANNEL = /^([\w.%-]{1,800}?)(!?)(~?)$/;

export function readScope(text: string): ScopeSpec | null {
  const [, names = '', high = '1', from, to] = SCOPE.exec(text) ?? [];
  const matches = names.split(',').map((name) => CHANNEL.exec(name));
  if (matches.length > TRACES_MAX) return null;
  const spec = { channels: [] as string[], hidden: [] as string[], own: [] as string[] };
  for (const each of matches) {
    const name = each && unescaped(each[1] as string);
    if (!name) return null;
    if (spec.channels.includes(name)) continue;
    spec.channels.push(name);
    if (each[2]) spec.hidden.push(name);
    if (each[3]) spec.own.push(name);
  }
  const size = Math.min(SIZE.most, Math.max(SIZE.least, Number(high)));
  const [low, most] = [Number(from), Number(to)];
  const hold =
    from !== undefined && most > low && Number.isFinite(most - low) ? ([low, most] as const) : null;
  return Number.isFinite(size) ? { ...spec, size, hold } : null;
}

/** Channels of imported runs may have any name, and expressions any sign. */
function escaped(name: string): string {
  return encodeURIComponent(name).replace(
    /[!~*'()]/g,
    (sign) => `%${(sign.codePointAt(0) ?? 0).toString(16).toUpperCase()}`,
  );
}

function unescaped(name: string): string {
  try {
    return decodeURIComponent(name);
  } catch {
    return '';
  }
}

/** One place of a list to another, where there is one. */
export function moved<T>(list: readonly T[], from: number, to: number): T[] {
  const next = [...list];
  if (to < 0 || to >= list.length || from < 0 || from >= list.length) return next;
  next.splice(to, 0, ...next.splice(from, 1));
  return next;
}

/** The sizes of two neighbours when the line between them moves by a share of both. */
export function resized(first: number, second: number, share: number): [number, number] {
  const both = first + second;
  const least = Math.min(SIZE.least, both / 4);
  const next = Math.min(both - least, Math.max(least, first + share * both));
  return [next, both - next];
}
