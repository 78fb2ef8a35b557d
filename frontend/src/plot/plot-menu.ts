/** The menu of a plot, by right click, menu key or its button: picture and numbers. */

import type { AxisScale } from './axis-scale';
import type { Canvas } from './canvas';
import type { Rows } from './heat-grid';
import type { Range } from './range';
import type { SampleSource } from './source';
import type { Band, Layer, Series } from './types';

/** Curves of a source over time. */
export interface SourceData {
  source: SampleSource | null;
  range: Range;
  traces: readonly { label: string; column: string; unit: string }[];
}

export interface CurveData {
  series: readonly Series[];
  bands: readonly Band[];
  x: AxisScale;
  y: AxisScale;
}

export interface GridData {
  xs: ArrayLike<number>;
  ys: ArrayLike<number>;
  rows: Rows;
  x: AxisScale;
  y: AxisScale;
  z: AxisScale;
  /** Further quantities, in the unit that they are shown in. */
  layers?: readonly Layer[];
}

/** The numbers that a plot shows. */
export type PlotData = SourceData | CurveData | GridData;

export interface ShownPlot {
  canvas: Canvas;
  /** Draws on a canvas, at once or in the next frame. */
  use: (canvas: Canvas) => void;
  data: (() => PlotData) | undefined;
}

/** By the element of its canvas. */
export const shownPlots = new WeakMap<Element, ShownPlot>();

export function plotMenu(event: MouseEvent): void {
  if (event.defaultPrevented) return;
  event.preventDefault();
  event.stopPropagation();
  const at = event.currentTarget as Element;
  const around = at.matches('button') ? at.closest('.surface, figure, section') : at;
  const plot = shownPlots.get(around?.querySelector('canvas') as Element);
  if (plot) void import('./plot-choices').then(({ open }) => open(plot, event));
}
