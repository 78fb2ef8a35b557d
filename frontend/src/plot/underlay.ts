/** What a chart draws behind its curves: bands of a study, curves of other runs. */

import type { AxisScale } from './axis-scale';
import type { Canvas } from './canvas';
import type { Plane } from './plane';
import type { Range } from './range';

export interface Underlay {
  /** Changes whenever there is something new to draw; no two share one. */
  readonly version: number;
  /** Reads what the window holds for so many pixels; returns its least and largest value. */
  read(range: Range, pixels: number): readonly [number, number];
  draw(canvas: Canvas, x: AxisScale, y: AxisScale): void;
}

/** The same of the plane. */
export interface PathUnderlay {
  readonly version: number;
  /** Reads a stretch of time; returns the largest error in it, m. */
  read(range: Range): number;
  /** Draws the movers with errors so many times larger, and where they are at one moment. */
  draw(canvas: Canvas, plane: Plane, factor: number, at: number): void;
}

let versions = 0;

export const nextVersion = () => ++versions;
