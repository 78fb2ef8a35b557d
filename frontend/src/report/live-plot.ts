/** A plot of the report with the curves of a run that the page has simulated, over the recorded ones. */

import { AxisScale } from '../plot/axis-scale';
import type { Axis } from '../kernel/lanes';
import { pathOf } from './svg-path';
import type { Experiment } from './experiment';

const SVG = 'http://www.w3.org/2000/svg';
/** Room beyond the ends of a curve that leaves the plot, as a share of the axis. */
const ROOM = 0.06;
/** Between two ticks, in units of the plot. */
const APART = 30;

/** Ends of an axis, and their places in the plot. */
interface Ends {
  low: number;
  high: number;
  begin: number;
  end: number;
}

interface Recorded {
  group: SVGGElement;
  live: SVGPathElement;
  variant: string;
  channel: string;
  axis: Axis;
}

export class LivePlot {
  private readonly x: Ends;
  private readonly y: Ends;
  private readonly curves: Recorded[];
  private readonly samples: number;
  /** Lines and numbers of the axis, as recorded. */
  private readonly levels: Element;
  private readonly recorded: readonly Node[];

  constructor(
    private readonly svg: SVGSVGElement,
    variants: readonly string[],
  ) {
    this.x = endsOf(svg.dataset.x);
    this.y = endsOf(svg.dataset.y);
    this.samples = Number(svg.dataset.samples);
    const levels = svg.querySelector('.levels');
    if (!levels) throw new Error('a plot has no axis');
    this.levels = levels;
    this.recorded = [...levels.childNodes];
    this.curves = [...svg.querySelectorAll<SVGGElement>('g[data-column]')].flatMap((group) => {
      const [variant = '', axis, channel = ''] = (group.dataset.column ?? '').split('.');
      if (!variants.includes(variant)) return [];
      const live = document.createElementNS(SVG, 'path');
      live.setAttribute('class', `curve live ${group.dataset.look ?? ''}`);
      group.after(live);
      return [{ group, live, variant, channel, axis: axis as Axis }];
    });
  }

  /** Draws the latest run. */
  draw(experiment: Experiment): void {
    const read = this.curves.map(({ variant, channel, axis }) =>
      experiment.curve(variant, { channel, axis }, this.samples),
    );
    const shown = this.widened(read.flatMap(({ minimum, maximum }) => [minimum, maximum]));
    this.show(shown);
    this.curves.forEach(({ live }, i) => {
      const { minimum, maximum, bins } = read[i] as (typeof read)[number];
      const time = (bin: number) => {
        const begin = bins.from + bin * bins.size;
        return ((begin + Math.min(begin + bins.size, bins.to) - 1) / 2) * experiment.period;
      };
      const path = pathOf(
        minimum.length,
        (bin) => placeOf(this.x, time(bin)),
        (bin) => placeOf(shown, minimum[bin] as number),
        (bin) => placeOf(shown, maximum[bin] as number),
      );
      live.setAttribute('d', path);
    });
    this.svg.classList.add('tried');
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

function endsOf(text = ''): Ends {
  const [low = 0, high = 1, begin = 0, end = 1] = text.split(' ').map(Number);
  return { low, high, begin, end };
}

function placeOf({ low, high, begin, end }: Ends, value: number): number {
  return begin + ((value - low) / (high - low)) * (end - begin);
}

function element(name: string, attributes: Record<string, string | number>): SVGElement {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, String(value));
  return node;
}
