/** State and actions of the Paper screen. */

import type {
  Changes,
  Erratum,
  PaperDocument,
  PaperFigure,
  PaperKind,
  PaperRow,
} from '../../app/api/types';
import { JobStore } from '../../app/jobs/job-store.svelte';
import { screen } from '../../app/screen.svelte';
import { fromAddress, load, save, setAddress } from '../../app/storage';
import { app } from '../../app/store.svelte';
import {
  FILTERS,
  isOfKind,
  linesOf,
  passes,
  type Filter,
  type KindFilter,
  type PaperLine,
} from './rows';

class PaperStore {
  readonly job = new JobStore(app.api, 'reproduce');
  document = $state.raw<PaperDocument | null>(null);
  filter = $state<Filter>(load('paper-filter', 'all' as string) as Filter);
  kind = $state<KindFilter>(load('paper-kind', 'all' as string) as KindFilter);
  chosen = $state(fromAddress('row') ?? '');

  /** The document: complete, or the partial one of a running or cancelled job. */
  private readonly results = $derived(this.job.report?.result ?? this.job.report?.partial ?? null);
  readonly lines = $derived<readonly PaperLine[]>(
    this.document ? linesOf(this.document.rows, this.results?.rows ?? []) : [],
  );
  readonly shown = $derived(
    this.lines.filter((line) => passes(line, this.filter) && isOfKind(line, this.kind)),
  );
  /** The row that is chosen; until one is, the first that does not hold. */
  readonly line = $derived(
    this.lines.find(({ row }) => row.id === this.chosen) ??
      (this.chosen === '' ? this.lines.find((line) => passes(line, 'red')) : undefined) ??
      null,
  );
  readonly figures = $derived<readonly PaperFigure[]>(this.results?.figures ?? []);
  readonly errata = $derived<readonly Erratum[]>(this.results?.errata ?? []);
  readonly doing = $derived(this.job.active ? (this.job.report?.partial?.doing ?? '') : '');
  /** Which model computed what is shown. */
  readonly made = $derived(this.job.report?.result ?? null);

  async open(): Promise<void> {
    if (!FILTERS.some(({ value }) => value === this.filter)) this.filter = 'all';
    await app.try(async () => {
      const [document] = await Promise.all([app.api.paper(), this.job.resume()]);
      if (!document.kinds.some(({ id }) => id === this.kind)) this.kind = 'all';
      this.document = document;
    });
  }

  async start(): Promise<void> {
    await app.try(() => this.job.start('/reproduce', {}));
  }

  choose(id: string): void {
    this.chosen = id;
    setAddress({ row: id });
  }

  show(filter: Filter): void {
    this.filter = filter;
    save('paper-filter', filter);
  }

  showKind(kind: KindFilter): void {
    this.kind = kind;
    save('paper-kind', kind);
  }

  kindOf(row: PaperRow): PaperKind | null {
    return this.document?.kinds.find(({ id }) => id === row.kind) ?? null;
  }

  figure(id: string | null): PaperFigure | null {
    return this.figures.find((figure) => figure.id === id) ?? null;
  }

  /** Opens a recipe's scenario in the Lab, in place of what runs there. */
  async inLab(scenario: string, set: Changes): Promise<void> {
    await app.loadScenario(scenario, set);
    screen.go('lab');
  }
}

export const paper = new PaperStore();
