/** Runs that are drawn behind the curves of the Lab; the address has them. */

import type { Range } from '../../plot/source';
import { fromAddress, setAddress } from '../../app/storage';
import { OverlaidRun } from './overlaid-run.svelte';
import { MOST, readOverlay, writeOverlay, type Placed } from './overlay-address';

class Overlay {
  list = $state.raw<readonly OverlaidRun[]>([]);
  /** Whether the sheet with runs to choose from is wanted. */
  choosing = $state(false);

  has(id: string): boolean {
    return this.list.some((run) => run.id === id);
  }

  get full(): boolean {
    return this.list.length >= MOST;
  }

  /** Takes what the address says, which a link or the browser's back may have changed. */
  readAddress(): void {
    const text = fromAddress('overlay') ?? '';
    if (text !== this.written) this.put(readOverlay(text));
  }

  /** Adds runs as far as there is room; returns what the address has to say. */
  add(ids: readonly string[]): string {
    const known = this.list.length > 0 ? this.list : readOverlay(fromAddress('overlay') ?? '');
    const added = ids
      .filter((id) => known.every((run) => run.id !== id))
      .map((id) => ({ id, offset: 0, shown: true }));
    // Where there is no room for all, the oldest go.
    this.put([...known, ...added.slice(0, MOST)].slice(-MOST));
    return this.written;
  }

  remove(id: string): void {
    this.list = this.list.filter((run) => run.id !== id);
    this.tell();
  }

  setOffset(run: OverlaidRun, offset: number): void {
    run.offset = offset;
    this.tell();
  }

  toggle(run: OverlaidRun): void {
    run.shown = !run.shown;
    this.tell();
  }

  /** Reads what is missing over a stretch of time. */
  look(columns: readonly string[], range: Range, moving: boolean): void {
    for (const run of this.list) if (run.shown) run.look(columns, range, moving);
  }

  private put(runs: readonly Placed[]): void {
    const kept = this.list.filter(({ id }) => runs.some((run) => run.id === id));
    const slots = Array.from({ length: MOST }, (_, slot) => slot);
    const free = slots.filter((slot) => kept.every((run) => run.slot !== slot));
    this.list = runs.map((placed) => {
      const present = kept.find(({ id }) => id === placed.id);
      if (!present) return new OverlaidRun(placed, free.shift() ?? 0);
      present.offset = placed.offset;
      present.shown = placed.shown;
      return present;
    });
    this.tell();
  }

  private get written(): string {
    return writeOverlay(this.list);
  }

  private tell(): void {
    setAddress({ overlay: this.written });
  }
}

export const overlay = new Overlay();
