/** The gains of a report: sliders, each with a field for the number. */

import { digits, minus, parseNumber } from '../ui/units';
import { position, valueAfterKey, valueAt } from '../ui/log-slider';

/** One gain; numbers are SI. */
class Gain {
  value: number;
  readonly path: string;
  readonly run: string;
  private readonly range: HTMLInputElement;
  private readonly field: HTMLInputElement;

  constructor(
    private readonly row: HTMLElement,
    changed: () => void,
    refused: (reason: string) => void,
  ) {
    const [range, field] = row.querySelectorAll('input');
    if (!range || !field) throw new Error('a gain has no slider');
    [this.range, this.field] = [range, field];
    this.path = row.dataset.path ?? '';
    this.run = (row.dataset.run ?? '').trim();
    this.value = this.recorded;
    this.show();
    range.addEventListener('input', () => {
      this.set(valueAt(Number(range.value), this.ends));
      changed();
    });
    range.addEventListener('keydown', (event) => {
      const next = valueAfterKey(event.key, event.shiftKey, this.value, this.ends);
      if (next === null) return;
      event.preventDefault();
      this.set(next);
      changed();
    });
    field.addEventListener('change', () => {
      const value = this.typed();
      if (value === null) {
        field.ariaInvalid = 'true';
        refused(`${field.ariaLabel ?? ''}: ${this.allowed}`);
        return;
      }
      this.set(value);
      changed();
    });
  }

  get recorded(): number {
    return this.number('value');
  }

  set(value: number): void {
    this.value = value;
    this.show();
  }

  private get ends() {
    return { least: this.number('least'), most: this.number('most') };
  }

  private get allowed(): string {
    const [low, high] = [this.number('minimum'), this.number('maximum')];
    const ends = [low, high].map((end) => digits(end * this.number('factor')));
    return `${ends.join(' to ')} ${this.row.dataset.unit ?? ''} are allowed`;
  }

  private typed(): number | null {
    const shown = parseNumber(this.field.value);
    if (shown === null) return null;
    const value = shown / this.number('factor');
    return value >= this.number('minimum') && value <= this.number('maximum') ? value : null;
  }

  private show(): void {
    this.range.value = String(position(this.value, this.ends));
    const shown = Number((this.value * this.number('factor')).toPrecision(7));
    this.field.value = minus(String(shown));
    this.range.setAttribute('aria-valuetext', `${this.field.value} ${this.row.dataset.unit ?? ''}`);
    this.field.ariaInvalid = null;
    this.row.classList.toggle('moved', this.value !== this.recorded);
  }

  private number(name: string): number {
    return Number(this.row.dataset[name]);
  }
}

/** A switch, and the values of what it changes where it is off, and where it is on. */
class Switch {
  readonly run: string;
  private readonly box: HTMLInputElement;
  private readonly ends: Record<string, [off: number, on: number]>;

  constructor(
    private readonly label: HTMLElement,
    changed: () => void,
  ) {
    const box = label.querySelector('input');
    if (!box) throw new Error('a switch has no box');
    this.box = box;
    this.run = (label.dataset.run ?? '').trim();
    this.ends = JSON.parse(label.dataset.switch ?? '{}') as typeof this.ends;
    this.back(); // a browser may keep what was before a reload
    box.addEventListener('change', () => {
      this.mark();
      changed();
    });
  }

  get values(): [path: string, value: number][] {
    return Object.entries(this.ends).map(([path, [off, on]]) => [
      path,
      this.box.checked ? on : off,
    ]);
  }

  back(): void {
    this.box.checked = this.box.defaultChecked;
    this.mark();
  }

  private mark(): void {
    this.label.classList.toggle('moved', this.box.checked !== this.box.defaultChecked);
  }
}

export class Sliders {
  private readonly gains: readonly Gain[];
  private readonly switches: readonly Switch[];

  constructor(tools: ParentNode, changed: () => void, refused: (reason: string) => void) {
    const [rows, labels] = ['[data-path]', '[data-switch]'].map((selector) => [
      ...tools.querySelectorAll<HTMLElement>(selector),
    ]) as [HTMLElement[], HTMLElement[]];
    this.gains = rows.map((row) => new Gain(row, changed, refused));
    this.switches = labels.map((label) => new Switch(label, changed));
  }

  /** Values by path, of the run of a number. */
  valuesOf(number: string): Map<string, number> {
    const own = <T extends { run: string }>(all: readonly T[]) =>
      all.filter(({ run }) => run === number);
    return new Map([
      ...own(this.gains).map(({ path, value }) => [path, value] as const),
      ...own(this.switches).flatMap(({ values }) => values),
    ]);
  }

  back(): void {
    for (const gain of this.gains) gain.set(gain.recorded);
    for (const each of this.switches) each.back();
  }
}
