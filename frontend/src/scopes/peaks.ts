/** Peaks of a curve, largest and least alike, found in every sample. */

import { differenceOf, extremes, type SampleSource } from '../plot/source';
import type { TimeView } from './time-view.svelte';
import { messages } from '../app/messages.svelte';
import { channelName } from '../plot/scope-catalog';
import { copyText } from '../ui/export';
import { digits, quantity } from '../ui/units';

/** How far a curve has to go back on both sides of a peak, as a share of peak to peak of what is visible. */
export const PROMINENCE = 0.1;
/** Read at a time, s: every sample comes of so much. */
const LEAST = 1;
const MOST = 60;

export interface Peak {
  column: string;
  time: number;
  value: number;
}

interface Turn {
  place: number;
  value: number;
}

/**
 * Tells where a curve has turned: once it has gone back from an extreme by the prominence, having come
 * to it by as much. What it did before its first sample is not known, so its first extreme is none.
 */
export class Turns {
  private low = Number.POSITIVE_INFINITY;
  private high = Number.NEGATIVE_INFINITY;
  private lowAt = 0;
  private highAt = 0;
  /** 1 while it rises, -1 while it falls, 0 before either is known. */
  private way = 0;

  constructor(private readonly prominence: number) {}

  /** Takes the next sample; returns the peak that it shows to be one, else null. */
  next(place: number, value: number): Turn | null {
    if (value > this.high) [this.high, this.highAt] = [value, place];
    if (value < this.low) [this.low, this.lowAt] = [value, place];
    if (this.way >= 0 && value <= this.high - this.prominence) {
      const turn = this.way === 0 ? null : { place: this.highAt, value: this.high };
      [this.way, this.low, this.lowAt] = [-1, value, place];
      return turn;
    }
    if (this.way <= 0 && value >= this.low + this.prominence) {
      const turn = this.way === 0 ? null : { place: this.lowAt, value: this.low };
      [this.way, this.high, this.highAt] = [1, value, place];
      return turn;
    }
    return null;
  }
}

/** The column whose peaks are looked for: the chosen one, else the first trace that is shown. */
export function peakColumn(view: TimeView): string {
  const shown = view.scopes.flatMap(({ traces }) => traces.map(({ column }) => column));
  return shown.includes(view.peaksOf) ? view.peaksOf : (shown[0] ?? '');
}

/** Finds the next peak after the last cursor, or the one before it; null where there is none. */
export async function nextPeak(view: TimeView, way: 1 | -1): Promise<Peak | null> {
  const column = peakColumn(view);
  const { source, range, extent, period, cursors } = view;
  if (!source || column === '' || !(period > 0)) return null;
  const [low, high] = extremes(source, column, range);
  if (!(high > low)) return null;
  const turns = new Turns(PROMINENCE * (high - low));
  const now = cursors.at(-1) ?? (way > 0 ? range.from : range.to);
  const first = Math.round(now / period);
  const end = way > 0 ? extent.to : extent.from;
  const length = Math.min(MOST, Math.max(LEAST, range.to - range.from));
  // What lies before tells whether the curve rises or falls to what comes first.
  const begin = way > 0 ? extent.from : extent.to;
  const lead = Math.min(length / period, Math.max(0, way * (first - begin / period)));
  for (let from = first - way * Math.round(lead); way * (end / period - from) > 0.5;) {
    const count = Math.min(Math.round(length / period), Math.ceil(way * (end / period - from)));
    const to = from + way * count;
    const part = await samplesOf(
      view,
      column,
      Math.min(from, to) * period,
      Math.max(from, to) * period,
    );
    if (!part) return null;
    for (let tick = from; tick !== to; tick += way) {
      // Between this sample and the next, so that rounding finds this one.
      const value = part.at(column, (tick + part.inside) * period);
      if (Number.isNaN(value)) continue;
      const turn = turns.next(tick, value);
      if (turn && way * (turn.place - first) > 0) {
        return { column, time: turn.place * period, value: turn.value };
      }
    }
    from = to;
  }
  return null;
}

/** Every sample of a stretch: of the ring, or read. A still source has a sample from its time on. */
async function samplesOf(view: TimeView, column: string, from: number, to: number) {
  const { source, period } = view;
  const every = (each: SampleSource, inside: number) => ({
    inside,
    at: (name: string, time: number) => each.at(name, time),
  });
  const captured = view.trigger.shown;
  if (captured && view.coming) return every(captured.source, 0.5);
  if (view.coming && source) return every(source, 0);
  const { minuend, subtrahend } = differenceOf(column) ?? {};
  const read = minuend && subtrahend ? [minuend, subtrahend] : [column];
  const samples = await view.samples(read, { from, to: to + period });
  return samples && every(samples, 0.5);
}

export function tellPeak(view: TimeView, peak: Peak | null, way: 1 | -1): void {
  if (!peak) {
    const where = way > 0 ? 'after' : 'before';
    messages.info(`No peak ${where} the cursor that stands out by a tenth of what is visible.`);
    return;
  }
  const { column, time, value } = peak;
  const bare = column.replace(/^A-B\./, 'A.');
  const unit = view.channels.find(({ name }) => name === bare)?.unit ?? '1';
  const read = quantity(value, unit);
  const text = `${column}: ${read.number} ${read.unit} at ${digits(time, 7)} s`;
  // All digits, SI, as other programs read them.
  const exact = `${column}\t${time}\t${value}`;
  const why = view.whyOf?.(column);
  messages.info(`Peak of ${channelName(column)}, ${text}`, [
    { name: 'Copy', run: () => void copyText(exact) },
    ...(why ? [{ name: 'Why?', run: why }] : []),
  ]);
}
