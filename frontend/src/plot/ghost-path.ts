/** Paths of the movers of another run, behind the present ones. */

import type { Canvas } from './canvas';
import { pathBins, pathValues } from './mover-plane';
import { looksOf } from './palette';
import type { Plane } from './plane';
import type { Range } from './range';
import {
  looked,
  lookOfVariant,
  nextVersion,
  STRENGTH,
  type Drawn,
  type GhostRun,
  type PathUnderlay,
} from './run-overlay';
import type { SampleSource } from './source';
import type { Dash, Look } from './types';

/** Path of one mover of another run: its reference less the factor times its error. */
export class GhostPath implements PathUnderlay {
  readonly version = nextVersion();
  private points: Record<'x' | 'y' | 'ex' | 'ey', Float32Array> | null = null;
  private range: Range = { from: 0, to: 0 };
  private largest = 0;
  private readonly look: Look;

  constructor(
    private readonly source: SampleSource,
    private readonly variant: string,
    look: Dash | Look,
    /** The stretch that is drawn, where it is not that of the path before it. */
    private readonly own: Range | null = null,
  ) {
    this.look = { ink: looksOf(variant).ink ?? 'text', width: 1.25, ...looked(look) };
  }

  read(shown: Range): number {
    const { source, variant } = this;
    const { from, to } = this.own ?? shown;
    // It moves on by a moment far more often than by its range.
    if (this.points && from === this.range.from && to === this.range.to) return this.largest;
    this.range = { from, to };
    const bins = pathBins(source, { from, to });
    const points = {
      x: pathValues(source, 'x.position_reference', bins),
      y: pathValues(source, 'y.position_reference', bins),
      ex: pathValues(source, `${variant}.x.following_error`, bins),
      ey: pathValues(source, `${variant}.y.following_error`, bins),
    };
    this.points = points;
    this.largest = 0;
    points.ex.forEach((ex, i) => {
      const error = Math.hypot(ex, points.ey[i] as number);
      if (error > this.largest) this.largest = error;
    });
    return this.largest;
  }

  draw(canvas: Canvas, plane: Plane, factor: number, at: number): void {
    const { c } = canvas;
    const { points } = this;
    const { ink = 'text', width = 1.25, dash } = this.look;
    if (!points) return;
    c.globalAlpha = STRENGTH;
    canvas.pen(ink, width, dash);
    c.beginPath();
    canvas.trace(points.x.length, (i) => [
      plane.px((points.x[i] as number) - factor * (points.ex[i] as number)),
      plane.py((points.y[i] as number) - factor * (points.ey[i] as number)),
    ]);
    c.stroke();
    const [x, y] = (['x', 'y'] as const).map(
      (axis) =>
        this.source.at(`${axis}.position_reference`, at) -
        factor * this.source.at(`${this.variant}.${axis}.following_error`, at),
    ) as [number, number];
    if (Number.isFinite(x + y)) {
      canvas.pen(ink, 1.5);
      c.beginPath();
      c.arc(plane.px(x), plane.py(y), 4, 0, 2 * Math.PI);
      c.stroke();
    }
    c.globalAlpha = 1;
  }
}

const paths = new WeakMap<GhostRun, Drawn<PathUnderlay>>();

/** Paths of the movers of the runs. */
export function movers(
  runs: readonly GhostRun[],
  variants: readonly string[],
  range: Range,
): readonly PathUnderlay[] {
  return runs.flatMap((run) => {
    const source = run.shown ? run.over(range) : null;
    if (!source) return [];
    const drawn = paths.get(run);
    if (drawn?.source === source) return drawn.list;
    const list = variants.flatMap((variant) =>
      source.has(`${variant}.x.following_error`)
        ? [new GhostPath(source, variant, lookOfVariant(run, variant))]
        : [],
    );
    paths.set(run, { source, list });
    return list;
  });
}
