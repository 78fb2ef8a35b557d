/** The metrics of a run that the page has simulated, beside those recorded. */

import type { Axis } from '../kernel/lanes';
import type { Result } from '../kernel/result';
import { digits } from '../ui/units';

/** Cells of the report that hold a metric, and those that hold the second over the first of a row. */
export class LiveFigures {
  private readonly cells: readonly HTMLElement[];
  private readonly ratios: readonly HTMLElement[];

  constructor(document: ParentNode) {
    this.cells = [...document.querySelectorAll<HTMLElement>('[data-metric]')];
    this.ratios = [...document.querySelectorAll<HTMLElement>('[data-ratio]')];
  }

  /** Shows metrics of a run: empty, or its number in a comparison. */
  show(run: string, { variants }: Result): void {
    for (const cell of this.cells) {
      const { metric = '' } = cell.dataset;
      const [key = '', variant = '', number = ''] = metric.split(' ').reverse();
      const figures = number === run ? variants[variant] : undefined;
      if (!figures) continue;
      const [place = '', name = ''] = key.split('.');
      const value = (place === 'contour' ? figures.contour : figures.axes[place as Axis])?.[name];
      write(cell, value ?? Number.NaN, Number(cell.dataset.size));
    }
    for (const cell of this.ratios) {
      const row =
        cell.parentElement?.querySelectorAll<HTMLElement>('[data-metric] .computed') ?? [];
      const [first, second] = [...row].map((computed) => Number(computed.dataset.value));
      if (first !== undefined && second !== undefined) write(cell, second / first, 1);
    }
  }

  /**
   * Whether what is shown agrees with the record, as a run with the recorded gains has to: following errors
   * to two counts of an encoder of 50 nm and a hundredth. A loop at its stability boundary, which amplifies
   * rounding, does not.
   */
  get agrees(): boolean {
    return this.cells
      .filter(({ dataset }) => dataset.metric?.endsWith('.max_abs_following_error'))
      .every((cell) => {
        const recorded = Number(cell.querySelector('data')?.value);
        const computed = Number(cell.querySelector<HTMLElement>('.computed')?.dataset.value);
        return !(Math.abs(computed - recorded) > 100e-9 + 0.01 * Math.abs(recorded));
      });
  }

  clear(): void {
    for (const cell of [...this.cells, ...this.ratios])
      cell.querySelector<HTMLElement>('.computed')?.remove();
  }
}

function write(cell: HTMLElement, value: number, size: number): void {
  const computed = cell.querySelector<HTMLElement>('.computed') ?? document.createElement('span');
  computed.className = 'computed';
  computed.textContent = digits(value / size);
  computed.dataset.value = String(value);
  cell.append(computed);
}
