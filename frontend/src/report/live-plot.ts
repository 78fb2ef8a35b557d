/** A plot of the report with the curves of a run that the page has simulated, over the recorded ones. */

import { AxisScale } from '../plot/axis-scale';
import type { Axis } from '../kernel/lanes';
import type { Column, Curve } from '../kernel/tasks';
import { differenceOf, type Samples } from './difference';
import type { Experiment } from './experiment';
import { element, type Ends, endsOf, placeOf } from './svg-axis';
import { pathOf } from './svg-path';

/** Room beyond the ends of a curve that leaves the plot, as a share of the axis. */
const ROOM = 0.06;
/** Between two ticks, in units of the plot. */
const APART = 30;

/** A column of a run, and the tick of it at the first instant of the plot. */
interface Source {
  experiment: Experiment;
  variant: string;
  column: Column;
  first: number;
}

interface Recorded {
  group: SVGGElement;
  live: SVGPathElement;
  source: Source;
  /** What is taken away. */
  less: Source | null;
}

/** Bins from an instant on. */
interface Read extends Curve {
  from: number;
  to: number;
}

export class LivePlot {
  private readonly x: Ends;
  private readonly y: Ends;
  private readonly curves: Recorded[];
  /** Instants are at start + k step, so many in a bin. */
  private readonly grid: { start: number; step: number; samples: number };
  /** Lines and numbers of the axis, as recorded. */
  private readonly levels: Element;
  private readonly recorded: readonly Node[];

  /** @param experiments by the number of their run */
  constructor(
    private readonly svg: SVGSVGElement,
    experiments: ReadonlyMap<string, Experiment>,
  ) {
    this.x = endsOf(svg.dataset.x);
    this.y = endsOf(svg.dataset.y);
    const [start = 0, step = 1, samples = 1] = (svg.dataset.grid ?? '').split(' ').map(Number);
    this.grid = { start, step, samples };
    const levels = svg.querySelector('.levels');
    if (!levels) throw new Error('a plot has no axis');
    this.levels = levels;
    this.recorded = [...levels.childNodes];
    this.curves = [...svg.querySelectorAll<SVGGElement>('g[data-column]')].flatMap((group) => {
      const { column, first, less, lessFirst, look = '' } = group.dataset;
      const source = sourceOf(experiments, column, first);
      const other = sourceOf(experiments, less, lessFirst);
      if (!source || (less !== undefined && !other)) return [];
      const live = element('path', { class: `curve live ${look}` }) as SVGPathElement;
      group.after(live);
      return [{ group, live, source, less: other }];
    });
  }

  /** Draws the latest runs. */
  draw(): void {
    const { start, step, samples } = this.grid;
    const read = this.curves.map(({ source, less }) => this.read(source, less));
    const shown = this.widened(read.flatMap(({ minimum, maximum }) => [minimum, maximum]));
    this.show(shown);
    this.curves.forEach(({ live }, i) => {
      const { minimum, maximum, from, to } = read[i] as Read;
      const middle = (bin: number) => {
        const begin = from + bin * samples;
        return start + (step * (begin + Math.min(begin + samples, to) - 1)) / 2;
      };
      const path = pathOf(
        minimum.length,
        (bin) => placeOf(this.x, middle(bin)),
        (bin) => placeOf(shown, minimum[bin] as number),
        (bin) => placeOf(shown, maximum[bin] as number),
      );
      live.setAttribute('d', path);
    });
    this.svg.classList.toggle('tried', this.curves.length > 0);
  }

  /** Reads a curve, or the difference of two, over the instants of the plot that are simulated. */
  private read(source: Source, less: Source | null): Read {
    const { start, step, samples } = this.grid;
    const count = 1 + Math.round((this.x.high - start) / step);
    const both = less ? [source, less] : [source];
    const from = Math.max(0, ...both.map(({ experiment, first }) => experiment.first - first));
    const ends = both.map(({ experiment, first }) => experiment.stop - first);
    const to = Math.max(from, Math.min(count, ...ends));
    const columns = both.map(({ experiment, variant, column, first }) =>
      experiment.curve(variant, column, first + from, first + to, less ? 1 : samples),
    );
    const [curve, other] = columns.map((each) => (less ? each.minimum : each));
    if (!less) return { ...(curve as Curve), from, to };
    return { ...differenceOf(curve as Samples, other as Samples, samples), from, to };
  }

  /** Goes back to the recorded curves alone. */
  clear(): void {
    this.show(this.y);
    for (const { live } of this.curves) live.setAttribute('d', '');
    this.svg.classList.remove('tried');
  }

  /** The axis, widened so that all is on it. */
  private widened(curves: readonly Float32Array[]): Ends {
    let { low, high } = this.y;
    for (const curve of curves) {
      for (const value of curve) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    const room = ROOM * (high - low);
    if (low < this.y.low) low -= room;
    if (high > this.y.high) high += room;
    return { ...this.y, low, high };
  }

  /** Moves the recorded curves and the ticks to another axis. */
  private show(shown: Ends): void {
    const { y } = this;
    const scale = (y.high - y.low) / (shown.high - shown.low);
    const move = placeOf(shown, y.low) - scale * y.begin;
    for (const { group } of this.curves) {
      group.setAttribute('transform', `translate(0 ${move}) scale(1 ${scale})`);
    }
    this.levels.replaceChildren(...(scale === 1 ? this.recorded : this.ticks(shown)));
  }

  private ticks(shown: Ends): Node[] {
    const { size = '1', unit = '' } = this.svg.dataset;
    const scale = { factor: 1 / Number(size), unit };
    const places = [shown.begin, shown.end] as const;
    const axis = new AxisScale({ label: '', unit: 'any', scale }, shown.low, shown.high, places);
    const ticks = axis.ticks(APART);
    return ticks.flatMap(({ value, text }, i) => {
      const place = placeOf(shown, value);
      const label = i === ticks.length - 1 ? `${text} ${unit}`.trim() : text;
      return [this.line(place, value === 0), this.label(place, label)];
    });
  }

  private line(y: number, zero: boolean): SVGElement {
    const ends = { x1: this.x.begin, x2: this.x.end, y1: y, y2: y };
    return element('line', { ...ends, class: zero ? 'zero' : 'grid' });
  }

  private label(y: number, text: string): SVGElement {
    const place = { x: this.x.begin - 6, y: y + 4 };
    const label = element('text', { ...place, 'text-anchor': 'end', class: 'y' });
    label.textContent = text;
    return label;
  }
}

/** A column such as "1 A.x.following_error", or without a number; null where it is not simulated. */
function sourceOf(
  experiments: ReadonlyMap<string, Experiment>,
  text = '',
  first = '0',
): Source | null {
  const [name = '', run = ''] = text.split(' ').reverse();
  const [variant = '', axis, channel = ''] = name.split('.');
  const experiment = experiments.get(run);
  if (!experiment?.variants.includes(variant)) return null;
  return { experiment, variant, column: { channel, axis: axis as Axis }, first: Number(first) };
}
