/** What workers are asked to run and read, and the curves of their answers. */

import type { Axis, Lanes } from '../../kernel/lanes';
import type { Bins, Column, Curve, Run } from '../../kernel/tasks';
import { type Range, StillSource } from '../../plot/source';

/** A column with the variant that it is read of; references are read of the first. */
export interface Place extends Column {
  name: string;
  variant: number;
}

/** The parameters of one variant over all epochs. */
export function runOf(
  lanes: Lanes,
  variant: string,
  index: number,
  places: readonly Place[],
  bins: Bins,
): Run {
  const count = lanes.tabled.length;
  const rows = lanes.lanes.length / (lanes.epochs.length * count);
  const state = lanes.state.length / count;
  const epochs = lanes.epochs.map((from, epoch) => {
    const first = (epoch * count + index) * rows;
    return { from, parameters: lanes.lanes.slice(first, first + rows) };
  });
  return {
    variant,
    epochs,
    state: lanes.state.slice(index * state, (index + 1) * state),
    tabled: lanes.tabled[index] as boolean,
    linear: lanes.epochs.length === 1, // else the first parameters may be later ones than the controls
    windows: lanes.windows,
    moving: lanes.moving,
    columns: ofVariant(places, index),
    bins,
  };
}

/** Whether two runs on the same inputs give the same. */
export function sameRun(a: Run, b: Run): boolean {
  const epochs = a.epochs.length === b.epochs.length;
  return (
    epochs &&
    a.epochs.every(({ from, parameters }, i) => {
      const other = b.epochs[i];
      return other?.from === from && sameNumbers(other.parameters, parameters);
    }) &&
    sameNumbers(a.state, b.state) &&
    restOf(a) === restOf(b)
  );
}

function restOf(run: Run): string {
  return JSON.stringify({ ...run, epochs: null, state: null });
}

function sameNumbers(a: Float64Array, b: Float64Array): boolean {
  return a.length === b.length && a.every((value, i) => Object.is(value, b[i]));
}

export function placesOf(columns: readonly string[], variants: readonly string[]): Place[] {
  return columns.map((name) => {
    const parts = name.split('.');
    const [axis, channel] = parts.slice(-2) as [Axis, string];
    return {
      name,
      channel,
      axis,
      variant: parts.length > 2 ? variants.indexOf(parts[0] ?? '') : 0,
    };
  });
}

export function ofVariant(places: readonly Place[], index: number): Column[] {
  return places
    .filter(({ variant }) => variant === index)
    .map(({ channel, axis }) => ({ channel, axis }));
}

/** Equal bins over a stretch of time, or over the window, within the run. */
export function binsOf(
  { first, stop, period, windows }: Pick<Lanes, 'first' | 'stop' | 'period' | 'windows'>,
  range: Range | null,
  points: number,
): Bins {
  const [window] = windows;
  const within = (tick: number) => Math.min(stop, Math.max(first, tick));
  let from = within(range ? Math.round(range.from / period) : (window?.start ?? first));
  let to = within(range ? Math.round(range.to / period) : (window?.end ?? stop));
  if (to <= from) [from, to] = [window?.start ?? first, window?.end ?? stop];
  return { from, to, size: Math.max(1, Math.ceil((to - from) / points)) };
}

export function sourceOf(
  places: readonly Place[],
  curves: readonly Curve[][],
  { from, to, size }: Bins,
  period: number,
): StillSource {
  const next = curves.map((each) => each[Symbol.iterator]());
  const columns = places.flatMap(({ name, variant }) => {
    const curve = next[variant]?.next().value;
    return curve ? [[name, curve] as const] : [];
  });
  const count = Math.ceil((to - from) / size);
  return new StillSource(from * period, size * period, count, new Map(columns));
}
