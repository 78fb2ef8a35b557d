/** Entries of a list that are found by typing some of their words. */

/** Choices of a select at most; more of them are found by typing. */
export const LISTED = 12;

export interface FinderOption<T extends string | number = string> {
  value: T;
  name: string;
  /** Beside the name, muted: a path, a unit. It is found too. */
  detail?: string;
  /** What is found besides, and shown on hover. */
  title?: string;
  /** The heading above it and those that follow with the same one. */
  group?: string;
}

/** Returns the options that have every word that was typed; first those that have them as whole words. */
export function matchingOptions<T extends string | number>(
  options: readonly FinderOption<T>[],
  typed: string,
): FinderOption<T>[] {
  const words = typed.toLowerCase().split(/\s+/).filter(Boolean);
  if (words.length === 0) return [...options];
  const ranked = options.flatMap((option) => {
    const { name, detail = '', title = '', group = '' } = option;
    const text = `${name} ${detail} ${title} ${group}`.toLowerCase();
    if (!words.every((word) => text.includes(word))) return [];
    const whole = new Set(name.toLowerCase().split(/[^\p{L}\p{N}_]+/u));
    return [{ option, rest: words.filter((word) => !whole.has(word)).length }];
  });
  return ranked.sort((a, b) => a.rest - b.rest).map(({ option }) => option);
}

/** Where a key of a list moves the mark; null of another key. */
export function movedMark(key: string, marked: number, count: number): number | null {
  const way = { ArrowDown: 1, ArrowUp: -1, PageDown: 10, PageUp: -10 }[key];
  return way === undefined ? null : Math.max(0, Math.min(count - 1, marked + way));
}
