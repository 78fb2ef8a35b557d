/** Documents of one kind that the server keeps by name: listed, saved, renamed, deleted with Undo. */

import { errorText } from '../../app/error-text';
import { messages } from '../../app/messages.svelte';

/** What a list has of a document. */
export interface SavedEntry {
  name: string;
  shipped?: boolean;
}

/** A kind of documents, and the calls that keep them. */
export interface SavedKind<E extends SavedEntry, D> {
  /** What one is called: "layout". */
  noun: string;
  list: () => Promise<readonly E[]>;
  drop: (name: string) => Promise<unknown>;
  put?: (name: string, document: D) => Promise<unknown>;
  /** What is saved again under another name, or by Undo; without it there is neither. */
  read?: (entry: E) => D | Promise<D>;
  /** Makes a name that the server takes of what was typed. */
  nameOf?: (typed: string) => string;
  /** Follows a change of what a name stands for. */
  changed?: (name: string, formerly?: string) => unknown;
  /** What Undo cannot bring back. */
  loss?: string;
}

export class SavedDocuments<E extends SavedEntry, D = never> {
  /** null until the server has answered. */
  entries = $state.raw<readonly E[] | null>(null);
  problem = $state('');
  busy = $state(false);
  /** A name in use, under which Save was pressed once. */
  private confirming = $state('');

  readonly own = $derived((this.entries ?? []).filter(({ shipped }) => !shipped));

  constructor(readonly kind: SavedKind<E, D>) {}

  nameOf(typed: string): string {
    return (this.kind.nameOf ?? trimmed)(typed);
  }

  /** Whether saving once more takes the place of another document. */
  overwrites(name: string): boolean {
    return this.confirming !== '' && this.confirming === name;
  }

  /** Whether there is a document of a name. */
  has(name: string): boolean {
    return (this.entries ?? []).some((entry) => entry.name === name);
  }

  /** Lists what there is; meanwhile a name can be typed and saved. */
  refresh = () => this.attempt(async () => undefined);

  /**
   * Saves a document under a name.
   *
   * @param again - the name under which it is saved already, which needs no confirmation
   * @returns whether it is saved; not where the name is in use and has to be confirmed
   */
  async save(name: string, document: D, again = ''): Promise<boolean> {
    // It may have been saved elsewhere since.
    if (name === '' || !(await this.refresh())) return false;
    if (this.has(name) && again !== name && !this.overwrites(name)) {
      this.confirming = name;
      return false;
    }
    this.confirming = '';
    return this.carryOut(() => this.put(name, document));
  }

  async rename(entry: E, typed: string): Promise<boolean> {
    const name = this.nameOf(typed);
    if (name === '' || name === entry.name) return true;
    return this.carryOut(async () => {
      if (this.has(name)) throw new Error(`There is a ${this.kind.noun} ${name} already.`);
      await this.put(name, await this.document(entry), entry.name);
      await this.kind.drop(entry.name);
    });
  }

  async remove(entry: E): Promise<boolean> {
    const { noun, read, drop, changed, loss = '' } = this.kind;
    const { name } = entry;
    return this.carryOut(async () => {
      const document = read ? await this.document(entry) : null;
      await drop(name);
      await changed?.(name);
      if (document === null) return;
      const back = () => void this.carryOut(() => this.put(name, document));
      messages.info(`The ${noun} ${name} is deleted.${loss}`, [{ name: 'Undo', run: back }]);
    });
  }

  private async put(name: string, document: D, formerly?: string): Promise<void> {
    await this.kind.put?.(name, document);
    await this.kind.changed?.(name, formerly);
  }

  private async document(entry: E): Promise<D> {
    if (!this.kind.read) throw new Error(`A ${this.kind.noun} cannot be read.`);
    return this.kind.read(entry);
  }

  /** Does something, one thing at a time for the buttons; returns whether it was done. */
  private async carryOut(work: () => Promise<unknown>): Promise<boolean> {
    this.busy = true;
    try {
      return await this.attempt(work);
    } finally {
      this.busy = false;
    }
  }

  /** Does something and lists what there is then; returns whether it was done. */
  private async attempt(work: () => Promise<unknown>): Promise<boolean> {
    this.problem = '';
    try {
      await work();
      this.entries = await this.kind.list();
      return true;
    } catch (error) {
      this.problem = errorText(error);
      return false;
    }
  }
}

function trimmed(text: string): string {
  return text.trim();
}
