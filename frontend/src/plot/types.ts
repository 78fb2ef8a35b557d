/** What Plot and HeatMap are given. All numbers are SI; the axes choose prefixes. */

import type { Scale } from '../ui/units';

/** A token of app.css: the colour follows the theme. */
export type PlotInk =
  | 'a'
  | 'b'
  | 'difference'
  | 'reference'
  | 'phase-a'
  | 'phase-b'
  | 'phase-c'
  | 'text'
  | 'muted'
  | 'good'
  | 'bad'
  | 'focus';

export type Dash = 'solid' | 'dash' | 'dot' | 'dashdot';
export type Marker = 'circle' | 'square' | 'triangle' | 'diamond' | 'cross' | 'plus';
/** Numbers of a curve; null and NaN are gaps. */
export type Numbers = ArrayLike<number | null>;

export interface Axis {
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

export interface Series {
  name: string;
  x: Numbers;
  y: Numbers;
  ink?: PlotInk;
  /** `line` joins the points, `step` holds each value until the next, `bars` stand on zero. */
  kind?: 'line' | 'points' | 'step' | 'bars';
  dash?: Dash;
  /** Drawn at each point; points without one are circles. */
  marker?: Marker;
  width?: number;
  /** Half lengths of error bars, or their two ends. */
  error?: Numbers;
  low?: Numbers;
  high?: Numbers;
}

/** The area between two curves. */
export interface Band {
  name: string;
  x: Numbers;
  low: Numbers;
  high: Numbers;
  ink?: PlotInk;
  /** Hatched besides being tinted, to tell two bands apart. */
  hatched?: boolean;
}

/** A line across the plot at a value of one axis. */
export interface Mark {
  axis: 'x' | 'y';
  at: number;
  label: string;
  ink?: PlotInk;
  dash?: Dash;
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
  ink?: PlotInk;
  marker?: Marker;
  /** One entry of the legend for all points of a family, which look alike: "movers". */
  family?: string;
}

export type Line = Pick<Series, 'name' | 'x' | 'y' | 'ink' | 'dash' | 'width'>;

export const DASHES: Record<Dash, string | undefined> = {
  solid: undefined,
  dash: '6 4',
  dot: '1.5 3',
  dashdot: '7 3 1.5 3',
};
