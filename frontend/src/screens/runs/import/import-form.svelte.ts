/** A file that is to become a run: what the server makes of it, and what the user says instead. */

import type { ImportDocument } from '../../../app/api/types';
import { LatestWins } from '../../../app/latest-wins';
import { messages } from '../../../app/messages.svelte';
import { importRun, type ImportQuery } from '../../../parts/runs/runs-api';
import { runs } from '../runs.svelte';
import {
  FINE,
  mapOf,
  problemsOf,
  secondTimeOf,
  withTime,
  type Correction,
  type Corrections,
  type Problems,
} from './import-text';

type Options = 'delimiter' | 'decimal' | 'rate' | 'resample' | 'align' | 'offset';
type ImportOptions = { [Name in Options]?: ImportQuery[Name] | undefined };

class ImportForm {
  file = $state.raw<File | null>(null);
  /** Another file of the same motion, with a clock of its own. */
  second = $state.raw<File | null>(null);
  /** How the second file is read by itself: both together do not list its column of time. */
  private secondAlone = $state.raw<ImportDocument | null>(null);
  name = $state('');
  options = $state.raw<ImportOptions>({});
  corrections = $state.raw<Corrections>({});
  /** How the file is read, as far as the last answer without a refusal. */
  preview = $state.raw<ImportDocument | null>(null);
  problems = $state.raw<Problems>(FINE);
  busy = $state(false);
  /** Columns of the first file. */
  private headers: readonly string[] = [];
  private readonly questions = new LatestWins<File>((file) => this.readPreview(file));

  readonly ready = $derived(
    this.preview !== null &&
      !this.busy &&
      this.preview.problems.length === 0 &&
      this.problems.file === '' &&
      Object.keys({ ...this.problems.fields, ...this.problems.columns }).length === 0,
  );

  /** The time of the second file; null until its columns are known. */
  readonly secondTime = $derived(
    this.secondAlone && secondTimeOf(this.secondAlone, this.corrections),
  );

  open(file: File): void {
    this.file = file;
    this.second = this.secondAlone = null;
    this.headers = [];
    this.name = file.name.slice(0, 80);
    this.options = {};
    this.corrections = {};
    this.preview = null;
    this.problems = FINE;
    this.ask();
  }

  add(second: File | null): void {
    this.second = second;
    this.secondAlone = null;
    this.options = { ...this.options, align: undefined, offset: undefined };
    // What was corrected of another second file is of no column now.
    const own = Object.entries(this.corrections).filter(([each]) => this.headers.includes(each));
    this.corrections = Object.fromEntries(own);
    this.ask();
  }

  close(): void {
    this.file = null;
  }

  say(some: ImportOptions): void {
    this.options = { ...this.options, ...some };
    if ('delimiter' in some || 'decimal' in some) this.secondAlone = null;
    this.ask();
  }

  correct(column: string, correction: Correction | null): void {
    const others = Object.entries(this.corrections).filter(([each]) => each !== column);
    this.corrections = Object.fromEntries(
      correction ? [...others, [column, correction]] : others,
    ) as Corrections;
    this.ask();
  }

  /** Says which column is the time of the second file, and in which unit; empty: as guessed. */
  timeSecond(column: string, unit = ''): void {
    if (!this.secondAlone) return;
    this.corrections = withTime(this.secondAlone, this.corrections, column, unit);
    this.ask();
  }

  /** Makes the run and selects it; returns whether it did. */
  async keep(): Promise<boolean> {
    const { file, corrections } = this;
    if (!file || !this.ready) return false;
    this.busy = true;
    try {
      const { run } = await importRun(this.body(file), this.query({ name: this.name.trim() }));
      if (!run) return false;
      await runs.added(run);
      messages.info(`“${this.name.trim() || 'measurement'}” is a run now.`);
      return true;
    } catch (error) {
      this.problems = problemsOf(error, corrections);
      return false;
    } finally {
      this.busy = false;
    }
  }

  private query(more: ImportQuery): ImportQuery {
    const options = Object.entries(this.options).filter(
      ([, value]) => value !== undefined && value !== '',
    );
    const two = this.second && this.file ? { first_bytes: this.file.size } : {};
    return { ...Object.fromEntries(options), map: mapOf(this.corrections), ...two, ...more };
  }

  private body(file: File): Blob {
    return this.second ? new Blob([file, this.second]) : file;
  }

  private ask(): void {
    if (!this.file) return;
    this.busy = true;
    this.questions.push(this.file);
  }

  private async readPreview(file: File): Promise<void> {
    const { corrections, second } = this;
    if (second && !this.secondAlone) await this.readSecond(second);
    try {
      const preview = await importRun(this.body(file), this.query({ preview: true }));
      if (file !== this.file) return;
      [this.preview, this.problems] = [preview, FINE];
      if (!preview.merged) this.headers = preview.columns.map(({ column }) => column);
    } catch (error) {
      if (file === this.file) this.problems = problemsOf(error, corrections);
    }
    this.busy = this.questions.superseded;
  }

  /** Reads the columns of the second file; what is wrong with it the answer of both says. */
  private async readSecond(second: File): Promise<void> {
    const { delimiter = '', decimal = '' } = this.options;
    const alone = await importRun(second, { preview: true, delimiter, decimal }).catch(() => null);
    if (second === this.second) this.secondAlone = alone;
  }
}

export const form = new ImportForm();
