/** What plots are given. All numbers are SI; the axes choose prefixes. */

import type { Scale } from '../ui/units';
import type { Ink } from './palette';

/** Lengths of dash and gap, CSS pixels. */
export const DASHES = {
  solid: [],
  dash: [6, 4],
  dot: [1.5, 3],
  dashdot: [7, 3, 1.5, 3],
  long: [12, 5],
} as const satisfies Record<string, readonly number[]>;

export type Dash = keyof typeof DASHES;
export type Marker = 'dot' | 'circle' | 'square' | 'triangle' | 'diamond' | 'cross' | 'plus';
/** Numbers of a curve; null and NaN are gaps. */
export type Numbers = ArrayLike<number | null>;

/** How a curve looks, on every plot and in every legend. */
export interface Look {
  ink?: Ink;
  dash?: Dash;
  /** Drawn at each point, over time at round times; points without one are circles. */
  marker?: Marker;
  width?: number;
  /** `line` joins the points, `step` holds each value until the next, `bars` stand on zero. */
  kind?: 'line' | 'points' | 'step' | 'bars';
  /** What lies between steps and zero: tinted, or hatched besides, to tell two apart. */
  area?: 'tinted' | 'hatched';
}

export interface PlotAxis {
  label: string;
  /** SI unit as in `units.ts`: `m`, `N`, `m/s^2`; `1` or nothing for a pure number. */
  unit?: string;
  /** Shown in this unit, whatever the size; without it the axis chooses a prefix. */
  scale?: Scale;
  log?: boolean;
  /** Ends of the axis; without them it fits the data. */
  from?: number;
  to?: number;
}

export interface Series extends Look {
  name: string;
  x: Numbers;
  y: Numbers;
  /** Half lengths of error bars, or their two ends. */
  error?: Numbers;
  low?: Numbers;
  high?: Numbers;
  /** The point that is marked and read, in place of the one nearest to the cursor. */
  at?: number;
}

/** The area between two curves. */
export interface Band {
  name: string;
  x: Numbers;
  low: Numbers;
  high: Numbers;
  ink?: Ink;
  /** Hatched besides being tinted, to tell two bands apart. */
  hatched?: boolean;
}

/** A line across the plot at a value of one axis. */
export interface Mark {
  axis: 'x' | 'y';
  at: number;
  label: string;
  ink?: Ink;
  dash?: Dash;
  /** The part of the other axis that it spans: a distance, labelled at its middle. */
  between?: readonly [number, number];
}

/** Where one reads; plots that share it are linked. `y` tells apart the branches of a loop. */
export interface Cursor {
  x: number;
  y: number | null;
}

export interface Spot {
  name: string;
  x: number;
  y: number;
  /** Written beside the marker. */
  label?: string;
  ink?: Ink;
  marker?: Marker;
  /** One entry of the legend for all points of a family, which look alike: "movers". */
  family?: string;
}

export interface Line extends Pick<Series, 'name' | 'x' | 'y' | 'ink' | 'dash' | 'width'> {
  /** Written on the line. */
  label?: string;
  /** One entry of the legend for all lines of a family. */
  family?: string;
}

/** A further quantity of a grid, in the unit that it is shown in. */
export interface Layer {
  label: string;
  unit: string;
  rows: readonly Numbers[];
}

/** Cells that are drawn faint and hatched. */
export interface Region {
  name: string;
  rows: readonly (readonly boolean[])[];
}

/** Entries of a legend that switch what they stand for. */
export interface Switches {
  /** By name, whether it is drawn; others are no switches. */
  on: Readonly<Record<string, boolean>>;
  toggle: (name: string) => void;
}
