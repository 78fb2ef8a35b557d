/** Where the axes of a plot are, in a frame of some size. */

import { AxisScale, ends, equalise, type Extent } from './axis-scale';
import type { PlotAxis } from './types';

export interface LayoutRequest {
  x: PlotAxis;
  y: PlotAxis;
  /** What the data span. */
  spans: { x: Extent | null; y: Extent | null };
  width: number;
  height: number;
  /** Room at the right edge, CSS pixels. */
  margin: number;
  /** Axes end where the data end. */
  tight: boolean;
  equal: boolean;
}

export interface Layout {
  x: AxisScale;
  y: AxisScale;
  left: number;
  right: number;
  top: number;
  bottom: number;
}

/** Least distance between two ticks of the value axis. */
export const ROW = 34;
const TOP = 8;
const BOTTOM = 36;
/** Name of the value axis, and each character of its ticks. */
const NAME = 22;
const CHARACTER = 7;

export function layout({
  x,
  y,
  spans,
  width,
  height,
  margin,
  tight,
  equal,
}: LayoutRequest): Layout {
  const alongY = ends(y, spans.y, tight);
  const bottom = Math.max(TOP + 20, height - BOTTOM);
  const trial = new AxisScale(y, ...alongY, [bottom, TOP]);
  const texts = trial.ticks(ROW).map(({ text }) => text.length);
  const left = NAME + CHARACTER * Math.max(2, ...texts);
  const right = Math.max(left + 20, width - margin);
  // Curves over x go from edge to edge; over a logarithmic x they keep a little room.
  const alongX = ends(x, spans.x, tight || x.log !== true);
  const ranges = equal
    ? equalise(alongX, alongY, right - left, bottom - TOP)
    : { x: alongX, y: alongY };
  const first = new AxisScale(x, ...ranges.x, [left, right]);
  const shared = equal && x.unit === y.unit ? first.shown : undefined;
  const second = new AxisScale(y, ...ranges.y, [bottom, TOP], shared);
  return { x: first, y: second, left, right, top: TOP, bottom };
}
