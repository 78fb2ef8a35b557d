/** The plane of a report with movers of a run that the page has simulated, over those recorded. */

import type { Experiment } from './experiment';
import { element, type Ends, endsOf, placeOf } from './svg-axis';
import { pathOf } from './svg-path';

interface Mover {
  variant: string;
  live: SVGElement;
}

export class LivePlane {
  private readonly x: Ends;
  private readonly y: Ends;
  /** Ticks [first, stop) are drawn, as so many points at most, with errors so many times as large. */
  private readonly plane: { first: number; stop: number; points: number; factor: number };
  private readonly movers: Mover[];

  constructor(
    private readonly svg: SVGSVGElement,
    private readonly experiment: Experiment,
  ) {
    this.x = endsOf(svg.dataset.x);
    this.y = endsOf(svg.dataset.y);
    const numbers = (svg.dataset.plane ?? '').split(' ').map(Number);
    const [first = 0, stop = 0, points = 1, factor = 1] = numbers;
    this.plane = {
      first: Math.max(first, experiment.first),
      stop: Math.min(stop, experiment.stop),
      points,
      factor,
    };
    this.movers = [...svg.querySelectorAll<SVGGElement>('g[data-mover]')].flatMap((group) => {
      const { mover: variant = '', look = '' } = group.dataset;
      if (!experiment.variants.includes(variant)) return [];
      const live = element('path', { class: `curve live ${look}` });
      const { x, y } = this;
      const [width, height] = [x.end - x.begin, y.begin - y.end];
      const box = { x: x.begin, y: y.end, width, height };
      const within = element('svg', { ...box, viewBox: `${x.begin} ${y.end} ${width} ${height}` });
      within.append(live); // which is cut where it leaves the picture
      group.after(within);
      return [{ variant, live }];
    });
  }

  /** Draws the latest run. */
  draw(): void {
    for (const { variant, live } of this.movers) live.setAttribute('d', this.path(variant));
    this.svg.classList.toggle('tried', this.movers.length > 0);
  }

  /** Goes back to the recorded movers alone. */
  clear(): void {
    for (const { live } of this.movers) live.setAttribute('d', '');
    this.svg.classList.remove('tried');
  }

  private path(variant: string): string {
    const { first, stop, points, factor } = this.plane;
    if (stop <= first) return '';
    const read = (channel: string, axis: 'x' | 'y') =>
      this.experiment.curve(variant, { channel, axis }, first, stop, 1).minimum;
    const error = { x: read('following_error', 'x'), y: read('following_error', 'y') };
    const reference = { x: read('position_reference', 'x'), y: read('position_reference', 'y') };
    const picked = largest(error.x, error.y, points);
    const place = (axis: 'x' | 'y', i: number) => {
      const tick = picked[i] as number;
      const value = (reference[axis][tick] as number) - factor * (error[axis][tick] as number);
      return placeOf(this[axis], value);
    };
    const y = (i: number) => place('y', i);
    return pathOf(picked.length, (i) => place('x', i), y, y);
  }
}

/** Returns the sample of each of so many bins whose error is largest, and both ends. */
export function largest(
  x: ArrayLike<number>,
  y: ArrayLike<number>,
  bins: number,
): readonly number[] {
  const step = Math.max(1, Math.ceil(x.length / bins));
  const picked = [0];
  for (let begin = 0; begin < x.length; begin += step) {
    let [at, most] = [begin, -1];
    for (let k = begin; k < Math.min(begin + step, x.length); k++) {
      const size = Math.hypot(x[k] as number, y[k] as number);
      if (size > most) [at, most] = [k, size];
    }
    if (at > 0) picked.push(at);
  }
  if (picked.at(-1) !== x.length - 1) picked.push(x.length - 1);
  return picked;
}
