/** Which rows are selected, and on which one the keys are. */

export interface Selection {
  ids: readonly string[];
  /** The row that the keys are on; empty where there is none. */
  at: string;
  /** Where a selection with Shift begins. */
  anchor: string;
}

export const NOTHING: Selection = { ids: [], at: '', anchor: '' };

export type How = 'only' | 'toggle' | 'range';

/** Returns the selection after a row was chosen: alone, added or taken away, or all up to it. */
export function chosen(now: Selection, order: readonly string[], id: string, how: How): Selection {
  if (how === 'toggle') {
    const others = now.ids.filter((each) => each !== id);
    return { ids: others.length < now.ids.length ? others : [...now.ids, id], at: id, anchor: id };
  }
  const [from, to] = [order.indexOf(now.anchor), order.indexOf(id)];
  if (how === 'only' || from < 0 || to < 0) return { ids: [id], at: id, anchor: id };
  const ids = order.slice(Math.min(from, to), Math.max(from, to) + 1);
  return { ids, at: id, anchor: now.anchor };
}

/** Returns the row some rows further down, within the list; the first where there was none. */
export function moved(order: readonly string[], at: string, by: number): string {
  const from = order.indexOf(at);
  const to = from < 0 ? 0 : Math.min(order.length - 1, Math.max(0, from + by));
  return order[to] ?? '';
}

/** Returns the row that follows rows that go, or the one before them. */
export function neighbour(order: readonly string[], gone: readonly string[]): string {
  const last = Math.max(...gone.map((id) => order.indexOf(id)));
  const stays = (id: string) => !gone.includes(id);
  return order.slice(last + 1).find(stays) ?? order.filter(stays).at(-1) ?? '';
}

/** Returns the first row that is drawn, and the one after the last, of a list that is scrolled. */
export function visible(
  { top, height }: { top: number; height: number },
  row: number,
  count: number,
): [number, number] {
  const spare = 4;
  const first = Math.max(0, Math.min(count, Math.floor(top / row)) - spare);
  return [first, Math.min(count, Math.ceil((top + height) / row) + spare)];
}
