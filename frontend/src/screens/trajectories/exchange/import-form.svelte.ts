/** A file or a text that is to become the path: how it is read, and what the server makes of it. */

import { LatestWins } from '../../../app/latest-wins';
import { editor } from '../editor.svelte';
import type { Point } from '../drawn-path';
import type { Checked } from '../feasibility';
import { readFile, type ReadFile, type ReadQuery } from './exchange-api';
import { isEdited, isWords, type Refusal, refusalOf, textOf } from './import-text';

/** Longer files are not shown in the box, characters. */
const SHOWN = 200_000;

export type ImportOptions = Required<
  Pick<ReadQuery, 'format' | 'unit' | 'scale' | 'tolerance' | 'placement' | 'height' | 'samples'>
>;

const NO_OPTIONS: ImportOptions = {
  format: 'auto',
  unit: 'mm',
  scale: 1,
  tolerance: 5e-6,
  placement: 'file',
  height: 0.01,
  samples: false,
};

interface Question {
  content: string;
  /** The file as it is, until its text is changed. */
  file: Blob | null;
  name: string;
  options: ImportOptions;
  stroke: Point;
}

class ImportForm {
  name = $state('');
  content = $state.raw('');
  options = $state.raw<ImportOptions>(NO_OPTIONS);
  imported = $state.raw<ReadFile | null>(null);
  checked = $state.raw<Checked | null>(null);
  refusal = $state.raw<Refusal | null>(null);
  busy = $state(false);
  /** Half of the stroke of the session's motor, m. */
  stroke: Point = [0.085, 0.145];
  private file: Blob | null = null;
  private readonly questions = new LatestWins<Question>((question) => this.preview(question));

  readonly shown = $derived(this.content.length <= SHOWN);
  readonly ready = $derived(this.imported !== null && this.refusal === null && !this.busy);

  /** Begins anew with a file. */
  async openFile(file: File): Promise<void> {
    const text = await textOf(file);
    this.begin(file.name, text, file);
    if (text.trim() === '') this.refusal = { line: null, text: 'The file is empty.', source: '' };
  }

  /** Begins anew with a text that was pasted. */
  openText(text: string): void {
    this.begin('', text, null);
  }

  /** Takes the text as it is typed; one that takes the place of a file's is no longer that file. */
  type(text: string): void {
    const another = this.content !== '' && text !== '' && !isEdited(this.content, text);
    if (another) {
      this.begin('', text, null);
      return;
    }
    if (text === '') this.name = '';
    [this.content, this.file] = [text, null];
    this.ask();
  }

  say(some: Partial<ImportOptions>): void {
    this.options = { ...this.options, ...some };
    this.ask();
  }

  /** Makes it the path of the editor, which can be undone; returns whether it did. */
  take(): boolean {
    if (!this.imported || !this.ready) return false;
    editor.set(this.imported.trajectory as typeof editor.table);
    editor.selected = null;
    const stem = this.name
      .replace(/\.[^.]*$/, '')
      .toLowerCase()
      .replace(/[^a-z0-9]+/g, '-')
      .replace(/^-+|-+$/g, '')
      .slice(0, 64);
    editor.rename(stem);
    return true;
  }

  private begin(name: string, content: string, file: Blob | null): void {
    [this.name, this.content, this.file] = [name, content, file];
    // Units and size of one file say nothing of the next; where it is to lie may well.
    this.options = { ...NO_OPTIONS, placement: this.options.placement };
    [this.imported, this.checked, this.refusal] = [null, null, null];
    this.ask();
  }

  private ask(): void {
    if (this.content.trim() === '') {
      [this.imported, this.checked, this.refusal] = [null, null, null];
      return;
    }
    this.busy = true;
    const { content, file, name, options, stroke } = this;
    this.questions.push({ content, file, name, options, stroke });
  }

  private async preview(question: Question): Promise<void> {
    const { content, file, name, options, stroke } = question;
    try {
      const imported = await readFile(file ?? new Blob([content]), {
        ...options,
        format: options.format === 'auto' && isWords(content) ? 'text' : options.format,
        filename: name.slice(-200),
        stroke_x: stroke[0],
        stroke_y: stroke[1],
      });
      const checked = await editor.examine(imported.trajectory as typeof editor.table);
      if (content === this.content) {
        [this.imported, this.checked, this.refusal] = [imported, checked, null];
      }
    } catch (error) {
      if (content === this.content) this.refusal = refusalOf(error, content);
    }
    this.busy = this.questions.superseded;
  }
}

export const form = new ImportForm();
