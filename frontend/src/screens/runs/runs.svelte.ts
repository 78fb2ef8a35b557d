/** The runs that a search finds, which of them are selected, and what is done with those. */

import type { Run, RunStorage, Scenario } from '../../app/api/types';
import { app } from '../../app/store.svelte';
import { errorText } from '../../app/error-text';
import { messages } from '../../app/messages.svelte';
import { fromAddress, load, save, setAddress } from '../../app/storage';
import {
  changeRun,
  deleteRun,
  listRuns,
  restoreRun,
  runStorage,
  type RunChange,
} from '../../parts/runs/runs-api';
import { searchProblem } from '../../parts/runs/run-text';
import { METRIC_COLUMNS, MOST, USUAL } from './columns';
import { viewOf, viewsAt, withView, type QuickView, type ViewId } from './search-text';
import { chosen, moved, neighbour, NOTHING, type How, type Selection } from './selection';

const PAGE = 100;
/** Most that one request gives. */
const PAGE_MAX = 200;
/** After the last key of the search field, ms. */
const TYPED = 200;
/** Between two looks at what is new, ms. */
const POLL = 4000;
/** Requests at once when many runs are changed. */
const AT_ONCE = 4;
/** Views that the storage does not count. */
const COUNTED = ['pinned', 'week', 'deleted'] as const;

export const SORTS = [
  { value: '-created', name: 'newest first' },
  { value: 'created', name: 'oldest first' },
  { value: 'name', name: 'by name' },
  { value: '-duration', name: 'longest first' },
  { value: '-size', name: 'largest first' },
] as const;

class Runs {
  query = $state(fromAddress('q') ?? '');
  sort = $state(keptSort());
  /** Metrics and fields that the list shows. */
  columns = $state.raw<readonly string[]>(
    load('runs.columns', [...USUAL] as string[]).slice(0, MOST),
  );
  list = $state.raw<readonly Run[]>([]);
  total = $state(0);
  /** Whether the first answer has come. */
  loaded = $state(false);
  loading = $state(false);
  /** What is wrong with the search, and why there is no answer. */
  refused = $state('');
  unreachable = $state('');
  storage = $state.raw<RunStorage | null>(null);
  private counted = $state.raw<Partial<Record<ViewId, number>>>({});
  selection = $state.raw<Selection>(addressed());
  readonly views = viewsAt(Date.now());
  readonly view = $derived(viewOf(this.query, this.views));
  readonly order = $derived(this.list.map(({ id }) => id));
  /** Runs that were seen, the selected ones of another search too. */
  private seen = $state.raw<Readonly<Record<string, Run>>>({});
  readonly selected = $derived(
    this.selection.ids.flatMap((id) => {
      const run = this.seen[id];
      return run ? [run] : [];
    }),
  );
  private shipped = $state.raw<Readonly<Record<string, Scenario | null>>>({});
  private cursor: string | null = null;
  private turn = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;

  /** Reads the list now and again; returns what stops it. */
  start(): () => void {
    void this.read();
    void this.count();
    const timer = setInterval(() => {
      if (document.visibilityState === 'visible') void this.refresh();
    }, POLL);
    return () => clearInterval(timer);
  }

  /** Takes what the address says, which a link or the browser's back may have changed. */
  readAddress(): void {
    const link = addressed();
    if (link.ids.length > 0) this.selection = link;
    this.tell();
    setAddress({ q: this.query });
  }

  /** Takes another search; while it is typed, soon. */
  search(query: string, soon = false): void {
    this.query = query;
    setAddress({ q: query });
    clearTimeout(this.timer);
    if (soon) this.timer = setTimeout(() => void this.read(), TYPED);
    else void this.read();
  }

  show(view: QuickView): void {
    this.search(withView(this.query, view, this.views));
  }

  sortBy(sort: string): void {
    this.sort = sort;
    save('runs.sort', sort);
    void this.read();
  }

  showColumns(columns: readonly string[]): void {
    this.columns = columns.slice(-MOST);
    save('runs.columns', this.columns);
    this.readShipped();
  }

  /** The shipped scenario of a name, read where a column shows a field; null until it is there. */
  shippedOf(name: string): Scenario | null {
    if (this.columns.every((id) => METRIC_COLUMNS.some((each) => each.id === id))) return null;
    return this.shipped[name] ?? null;
  }

  /** Reads the shipped scenarios of the list, for columns of fields. */
  private readShipped(): void {
    if (this.columns.every((id) => METRIC_COLUMNS.some((each) => each.id === id))) return;
    const known = app.catalogue.scenarios.map(({ name }) => name);
    for (const name of new Set(this.list.map(({ scenario }) => scenario))) {
      if (name in this.shipped || !known.includes(name)) continue;
      this.shipped = { ...this.shipped, [name]: null };
      void app.try(async () => {
        const scenario = await app.api.scenario(name);
        this.shipped = { ...this.shipped, [name]: scenario };
      });
    }
  }

  countOf(view: ViewId): number | undefined {
    const { storage } = this;
    if (view === 'all') return storage?.runs;
    if (view === 'measurements') return storage ? (storage.kinds.measurement ?? 0) : undefined;
    if (view === 'partial') return storage ? (storage.states.partial ?? 0) : undefined;
    return this.counted[view];
  }

  /** Reads the first page of the search. */
  async read(limit = PAGE): Promise<void> {
    const turn = ++this.turn;
    this.loading = true;
    const page = await this.ask(() => listRuns({ q: this.query, sort: this.sort, limit }));
    if (turn !== this.turn) return;
    this.loading = false;
    if (!page) return;
    this.refused = '';
    this.loaded = true;
    this.total = page.total;
    this.cursor = page.cursor;
    this.take(page.runs);
  }

  /** Reads the page after the last one. */
  async more(): Promise<void> {
    const { cursor } = this;
    if (cursor === null || this.loading) return;
    const turn = ++this.turn;
    this.loading = true;
    const { query: q, sort } = this;
    const page = await this.ask(() => listRuns({ q, sort, limit: PAGE, cursor }));
    if (turn !== this.turn) return;
    this.loading = false;
    if (!page) return;
    this.cursor = page.cursor;
    const { list, order } = this;
    // A run that came meanwhile has pushed the last ones of the page before onto this one.
    const last = order.slice(-PAGE);
    this.take([...list, ...page.runs.filter(({ id }) => !last.includes(id))]);
  }

  choose(id: string, how: How): void {
    if (id === '') return;
    this.selection = chosen(this.selection, this.order, id, how);
    this.tell();
  }

  /** Selects a run that was just made. */
  async added(id: string): Promise<void> {
    await this.read();
    this.choose(id, 'only');
    void this.count();
  }

  /** Selects these runs, in this order. */
  select(ids: readonly string[]): void {
    const [first = ''] = ids;
    this.selection = { ids, at: this.selection.at || first, anchor: first };
    this.tell();
  }

  chooseAll(): void {
    const [first = ''] = this.order;
    this.selection = { ids: this.order, at: this.selection.at || first, anchor: first };
    this.tell();
  }

  /** Moves the keys by some rows; with Shift they select on the way. */
  move(by: number, extend: boolean): void {
    this.choose(moved(this.order, this.selection.at, by), extend ? 'range' : 'only');
  }

  clear(): void {
    this.selection = NOTHING;
    this.tell();
  }

  /** A run that is known by its address, before the list has it. */
  note(run: Run): void {
    this.seen = { ...this.seen, [run.id]: run };
  }

  async change(runs: readonly Run[], changes: (run: Run) => RunChange): Promise<void> {
    await this.each(runs, async (run) => {
      const next = await changeRun(run.id, changes(run));
      this.list = this.list.map((each) => (each.id === next.id ? next : each));
      this.note(next);
    });
    void this.count();
  }

  async pin(runs: readonly Run[]): Promise<void> {
    const pinned = !runs.every((run) => run.pinned);
    await this.change(runs, () => ({ pinned }));
  }

  /** Deletes runs; a notice offers to take that back. */
  async remove(runs: readonly Run[]): Promise<void> {
    const next = neighbour(
      this.order,
      runs.map(({ id }) => id),
    );
    const gone: Run[] = [];
    await this.each(runs, async (run) => {
      await deleteRun(run.id);
      gone.push(run);
    });
    if (gone.length === 0) return;
    const ids = gone.map(({ id }) => id);
    this.list = this.list.filter(({ id }) => !ids.includes(id));
    this.total -= gone.length;
    if (next === '') this.clear();
    else this.choose(next, 'only');
    const what = gone.length === 1 ? `“${gone[0]?.name}” was` : `${gone.length} runs were`;
    messages.info(`${what} deleted.`, [{ name: 'Undo', run: () => void this.restore(gone) }]);
    void this.count();
    void this.refresh();
  }

  async restore(runs: readonly Run[]): Promise<void> {
    await this.each(runs, (run) => restoreRun(run.id).then((next) => this.note(next)));
    const [first] = runs;
    await this.read();
    const ids = runs.map(({ id }) => id);
    if (first) this.selection = { ids, at: first.id, anchor: first.id };
    this.tell();
    void this.count();
  }

  /** Looks for what is new, unless one has scrolled further than one answer reaches. */
  async refresh(): Promise<void> {
    const length = Math.max(PAGE, this.list.length);
    if (this.loading || this.refused !== '' || length > PAGE_MAX) return;
    const { total } = this;
    await this.read(length);
    if (this.total !== total) void this.count();
  }

  private async count(): Promise<void> {
    const counts = COUNTED.map(async (id) => {
      const q = this.views.find((view) => view.id === id)?.term ?? '';
      return [id, (await listRuns({ q, sort: '-created', limit: 1 })).total] as const;
    });
    // The list says when the index is out of reach.
    this.storage = await runStorage().catch(() => this.storage);
    this.counted = await Promise.all(counts).then(Object.fromEntries, () => this.counted);
  }

  /** Puts a list in place of the present one. */
  private take(runs: readonly Run[]): void {
    this.list = runs;
    this.readShipped();
    this.seen = { ...this.seen, ...Object.fromEntries(runs.map((run) => [run.id, run])) };
  }

  private async ask<T>(question: () => Promise<T>): Promise<T | null> {
    try {
      const answer = await question();
      this.unreachable = '';
      return answer;
    } catch (error) {
      const refused = searchProblem(error);
      if (refused !== '') this.refused = refused;
      else this.unreachable = errorText(error);
      return null;
    }
  }

  /** Does something with each of some runs, a few at once; a failure is reported once. */
  private async each(runs: readonly Run[], act: (run: Run) => Promise<void>): Promise<void> {
    const waiting = [...runs];
    const failed: string[] = [];
    const work = async () => {
      for (let run = waiting.shift(); run; run = waiting.shift()) {
        try {
          await act(run);
        } catch (error) {
          const text = errorText(error);
          if (!failed.includes(text)) failed.push(text);
        }
      }
    };
    await Promise.all(Array.from({ length: AT_ONCE }, work));
    if (failed.length > 0) messages.error(failed.join('\n'));
  }

  private tell(): void {
    setAddress({ run: this.selection.ids.slice(0, 8).join() });
  }
}

function addressed(): Selection {
  const all = (fromAddress('run') ?? '').split(',').filter((id) => id !== '');
  const ids = [...new Set(all)];
  const [first = ''] = ids;
  return { ids, at: first, anchor: first };
}

function keptSort(): string {
  const kept = load('runs.sort', '-created' as string);
  const known = SORTS.some(({ value }) => value === kept);
  return known || /^-?[A-Z]\.[xy]\.[a-z]+$/.test(kept) ? kept : '-created';
}

export const runs = new Runs();
