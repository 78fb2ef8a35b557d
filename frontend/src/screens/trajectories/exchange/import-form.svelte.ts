/** A file or a text that is to become the path: how it is read, and what the server makes of it. */

import { LatestWins } from '../../../app/latest-wins';
import { editor } from '../editor.svelte';
import type { Point } from '../drawn-path';
import type { Checked } from '../feasibility';
import { readFile, type ReadFile, type ReadQuery } from './exchange-api';
import { isEdited, isWords, type Refusal, refusalOf, textOf } from './import-text';

/** Longer files are not shown in the box, characters. */
const SHOWN = 200_000;

export type Said = Required<
  Pick<ReadQuery, 'format' | 'unit' | 'scale' | 'tolerance' | 'placement' | 'height' | 'samples'>
>;

const NOTHING_SAID: Said = {
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
  said: Said;
  stroke: Point;
}

class ImportForm {
  name = $state('');
  content = $state.raw('');
  said = $state.raw<Said>(NOTHING_SAID);
  found = $state.raw<ReadFile | null>(null);
  checked = $state.raw<Checked | null>(null);
  refusal = $state.raw<Refusal | null>(null);
  busy = $state(false);
  /** Half of the stroke of the session's motor, m. */
  stroke: Point = [0.085, 0.145];
  private file: Blob | null = null;
  private readonly questions = new LatestWins<Question>((question) => this.preview(question));

  readonly shown = $derived(this.content.length <= SHOWN);
  readonly ready = $derived(this.found !== null && this.refusal === null && !this.busy);

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

  say(some: Partial<Said>): void {
    this.said = { ...this.said, ...some };
    this.ask();
  }

  /** Makes it the path of the editor, which can be undone; returns whether it did. */
  take(): boolean {
    if (!this.found || !this.ready) return false;
    editor.set(this.found.trajectory as typeof editor.table);
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
    this.said = { ...NOTHING_SAID, placement: this.said.placement };
    [this.found, this.checked, this.refusal] = [null, null, null];
    this.ask();
  }

  private ask(): void {
    if (this.content.trim() === '') {
      [this.found, this.checked, this.refusal] = [null, null, null];
      return;
    }
    this.busy = true;
    const { content, file, name, said, stroke } = this;
    this.questions.push({ content, file, name, said, stroke });
  }

  private async preview(question: Question): Promise<void> {
    const { content, file, name, said, stroke } = question;
    try {
      const found = await readFile(file ?? new Blob([content]), {
        ...said,
        format: said.format === 'auto' && isWords(content) ? 'text' : said.format,
        filename: name.slice(-200),
        stroke_x: stroke[0],
        stroke_y: stroke[1],
      });
      const checked = await editor.examine(found.trajectory as typeof editor.table);
      if (content === this.content) {
        [this.found, this.checked, this.refusal] = [found, checked, null];
      }
    } catch (error) {
      if (content === this.content) this.refusal = refusalOf(error, content);
    }
    this.busy = this.questions.superseded;
  }
}

export const form = new ImportForm();
