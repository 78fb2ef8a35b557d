/** An axis: values to pixels and back, its round ticks and their texts. */

import {
  digits,
  minus,
  prettyUnit,
  quantity,
  scaleFor,
  type Quantity,
  type Scale,
} from '../ui/units';
import { multiples, roundStep } from './range';
import type { PlotAxis } from './types';

export interface Tick {
  value: number;
  /** Empty for the small ticks of a logarithmic axis. */
  text: string;
}

export interface Extent {
  low: number;
  high: number;
}

/** Least and largest finite value; of a logarithmic axis, positive ones only. */
export function extent(values: Iterable<number | null>, log = false): Extent | null {
  let [low, high] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
  for (const value of values) {
    if (value === null || !Number.isFinite(value) || (log && value <= 0)) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? { low, high } : null;
}

/** Ends of an axis around its data: with a little room, or exactly (`tight`). */
export function ends(axis: PlotAxis, data: Extent | null, tight = false): [number, number] {
  const log = axis.log === true;
  let { low, high } = data ?? (log ? { low: 1, high: 10 } : { low: 0, high: 1 });
  if (log) {
    if (low === high) [low, high] = [low / 2, high * 2];
    const room = tight ? 1 : (high / low) ** 0.04;
    [low, high] = [low / room, high * room];
  } else {
    const size = Math.max(Math.abs(low), Math.abs(high));
    // A constant gets a range of its own size.
    if (high - low <= 1e-9 * size || size === 0) {
      [low, high] = size === 0 ? [-1, 1] : [low - 0.25 * size, high + 0.25 * size];
    } else if (!tight) {
      const room = 0.05 * (high - low);
      // What has one sign and begins near zero begins at zero.
      [low, high] = [
        low >= 0 && low <= 0.25 * high ? 0 : low - room,
        high <= 0 && high >= 0.25 * low ? 0 : high + room,
      ];
    }
  }
  const usable = (end: number | undefined): end is number =>
    end !== undefined && Number.isFinite(end) && (!log || end > 0);
  const from = usable(axis.from) ? axis.from : low;
  const to = usable(axis.to) ? axis.to : high;
  if (to > from) return [from, to];
  return log ? [from, from * 10] : [from, from + 1];
}

export class AxisScale {
  readonly log: boolean;
  readonly label: string;
  /** Prefix and unit of the ticks. */
  readonly shown: Scale;
  private readonly a: number;
  private readonly b: number;

  /**
   * @param pixels where `from` and `to` are: [0, width], or [height, 0] for an axis that goes up
   * @param shared the prefix of another axis, for two that are drawn alike
   */
  constructor(
    readonly axis: PlotAxis,
    readonly from: number,
    readonly to: number,
    readonly pixels: readonly [number, number],
    shared?: Scale,
  ) {
    this.log = axis.log === true;
    this.label = axis.label;
    const unit = axis.unit ?? '1';
    const middle = this.log ? Math.sqrt(from * to) : Math.max(Math.abs(from), Math.abs(to));
    this.shown = shared ?? axis.scale ?? scaleFor(middle, unit);
    if (unit === '1') this.shown = { factor: 1, unit: prettyUnit(unit) };
    const [first, last] = [this.warp(from), this.warp(to)];
    this.b = (pixels[1] - pixels[0]) / (last - first);
    this.a = pixels[0] - this.b * first;
  }

  /** Pixel of a value; NaN where there is none. */
  px(value: number | null | undefined): number {
    return value === null || value === undefined ? Number.NaN : this.a + this.b * this.warp(value);
  }

  /** Value at a pixel. */
  at(px: number): number {
    const warped = (px - this.a) / this.b;
    return this.log ? 10 ** warped : warped;
  }

  holds(value: number): boolean {
    return value >= this.from && value <= this.to;
  }

  /** Round values about `apart` pixels from each other. */
  ticks(apart: number): Tick[] {
    const room = Math.max(1, Math.abs(this.pixels[1] - this.pixels[0]) / apart);
    return this.log ? this.logTicks(room) : this.linearTicks(room);
  }

  /** A value in the unit of the axis, precise enough to be read off. */
  text(value: number | null | undefined): string {
    if (value === null || value === undefined || !Number.isFinite(value)) return '–';
    const shown = value * this.shown.factor;
    if (this.log) return digits(shown);
    // No more digits than the axis can resolve, but four at least.
    const span = (this.to - this.from) * this.shown.factor;
    const places = Math.min(8, Math.max(0, 3 - Math.floor(Math.log10(span))));
    return minus(String(Number(shown.toFixed(places))));
  }

  /** A value with its unit: that of the axis, or on a logarithmic axis one of its own if none is given. */
  read(value: number | null | undefined): Quantity {
    if (this.log && !this.axis.scale) return quantity(value, this.axis.unit ?? '1');
    return { number: this.text(value), unit: this.shown.unit };
  }

  /** Ticks at some values, with as many decimals as tell them apart. */
  named(values: readonly number[]): Tick[] {
    const shown = values.map((value) => value * this.shown.factor);
    const exact = (digits: number) =>
      shown.every((value) => {
        const large = value * 10 ** digits;
        return Math.abs(large - Math.round(large)) <= 1e-6 * Math.max(1, Math.abs(large));
      });
    let places = 0;
    while (places < 12 && !exact(places)) places++;
    return values.map((value, i) => ({ value, text: minus((shown[i] ?? 0).toFixed(places)) }));
  }

  private linearTicks(room: number): Tick[] {
    const { from, to } = this;
    return this.named(multiples({ from, to }, roundStep((to - from) / room)));
  }

  private logTicks(room: number): Tick[] {
    const { factor } = this.shown;
    const [low, high] = [Math.log10(this.from * factor), Math.log10(this.to * factor)];
    const decades = high - low;
    // Every so many decades one text; of few decades also 2 and 5; of less than one, round steps.
    if (decades < 0.7) return this.linearTicks(room);
    const every = Math.max(1, Math.ceil(decades / room));
    const all = [1, 2, 3, 4, 5, 6, 7, 8, 9];
    const between = decades * 9 <= room ? all : decades * 3 <= room ? [1, 2, 5] : [1];
    const ticks: Tick[] = [];
    for (let decade = Math.floor(low); decade <= Math.ceil(high); decade++) {
      const digitsHere = decades > 12 ? [1] : all;
      for (const digit of digitsHere) {
        const value = (digit * 10 ** decade) / factor;
        if (value < this.from * (1 - 1e-9) || value > this.to * (1 + 1e-9)) continue;
        const named = between.includes(digit) && decade % every === 0;
        ticks.push({ value, text: named ? logText(digit, decade) : '' });
      }
    }
    return ticks;
  }

  private warp(value: number): number {
    if (!this.log) return value;
    return value > 0 ? Math.log10(value) : Number.NaN;
  }
}

function logText(digit: number, decade: number): string {
  if (decade >= -3 && decade <= 3) return minus(String(Number((digit * 10 ** decade).toFixed(4))));
  const power = [...String(decade)].map((c) => SUPERSCRIPTS[c] ?? c).join('');
  return `${digit === 1 ? '' : `${digit}·`}10${power}`;
}

const SUPERSCRIPTS: Record<string, string> = {
  '-': '⁻',
  '0': '⁰',
  '1': '¹',
  '2': '²',
  '3': '³',
  '4': '⁴',
  '5': '⁵',
  '6': '⁶',
  '7': '⁷',
  '8': '⁸',
  '9': '⁹',
};

/** Widens the shorter of two linear ranges so that a unit is as long along x as along y. */
export function equalise(
  x: readonly [number, number],
  y: readonly [number, number],
  width: number,
  height: number,
): { x: [number, number]; y: [number, number] } {
  const unit = Math.max((x[1] - x[0]) / width, (y[1] - y[0]) / height);
  const about = ([from, to]: readonly [number, number], size: number): [number, number] => {
    const middle = (from + to) / 2;
    return [middle - (unit * size) / 2, middle + (unit * size) / 2];
  };
  return { x: about(x, width), y: about(y, height) };
}
