/** Curves and paths of another run, behind the present ones: the same hue, muted, with dashes of the run. */

import type { AxisScale } from './axis-scale';
import type { Canvas } from './canvas';
import { pathBins, pathValues } from './mover-plane';
import type { Plane } from './plane';
import type { Range } from './range';
import type { SampleSource } from './source';
import { SourceCurve } from './source-curve';
import type { Trace, Traces } from './scope-chart';
import type { Dash, Look } from './types';
import { looksOf } from './palette';

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

const STRENGTH = 0.6;
/** Bins for each pixel: what lies behind is drawn for half the price. */
const COARSER = 0.5;

export class GhostCurve implements Underlay {
  readonly version = nextVersion();
  private readonly curve: SourceCurve;

  constructor(
    private readonly source: SampleSource,
    { column, ink = 'text' }: Trace,
    dash: Dash,
  ) {
    this.curve = new SourceCurve(column, { ink, dash, width: 1.25 });
  }

  read({ from, to }: Range, pixels: number): readonly [number, number] {
    return this.curve.read(this.source, this.source.cut(from, to, COARSER * pixels));
  }

  draw(canvas: Canvas, x: AxisScale, y: AxisScale): void {
    canvas.c.globalAlpha = STRENGTH;
    this.curve.draw(canvas, this.source, x, y);
    canvas.c.globalAlpha = 1;
  }
}

/** Path of one mover of another run: its reference less the factor times its error. */
export class GhostPath implements PathUnderlay {
  readonly version = nextVersion();
  private points: Record<'x' | 'y' | 'ex' | 'ey', Float32Array> | null = null;
  private range: Range = { from: 0, to: 0 };
  private largest = 0;

  constructor(
    private readonly source: SampleSource,
    private readonly variant: string,
    private readonly dash: Dash,
  ) {}

  read({ from, to }: Range): number {
    const { source, variant } = this;
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
    const { ink = 'text' } = looksOf(this.variant);
    if (!points) return;
    c.globalAlpha = STRENGTH;
    canvas.pen(ink, 1.25, this.dash);
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

const DASHES: readonly Dash[] = ['long', 'dot', 'dashdot', 'dash'];

export interface GhostRun {
  readonly shown: boolean;
  /** Tells it from the others: 0 to 3. */
  readonly slot: number;
  has(column: string): boolean;
  /** Its curves over a stretch of time of what it lies behind. */
  over(range: Range): SampleSource | null;
}

interface Drawn<T> {
  source: SampleSource;
  list: readonly T[];
}

const curves = new WeakMap<GhostRun, WeakMap<Traces, Drawn<Underlay>>>();
const paths = new WeakMap<GhostRun, Drawn<PathUnderlay>>();

function dashOf({ slot }: GhostRun): Dash {
  return DASHES[slot] ?? 'long';
}

/** The look of a run in legends. */
export function lookOf(run: GhostRun): Look {
  return { dash: dashOf(run), width: 2 };
}

/** Traces of a scope that a run has too; references would cover each other. */
export function tracesOf(run: GhostRun, { traces }: Traces): Trace[] {
  return traces.filter(
    ({ column, ink }) => run.has(column) && ink !== 'difference' && !column.endsWith('_reference'),
  );
}

/** What lies behind a scope: the same channels of the runs. */
export function behind(
  runs: readonly GhostRun[],
  scope: Traces,
  range: Range,
): readonly Underlay[] {
  return runs.flatMap((run) => {
    const source = run.shown ? run.over(range) : null;
    if (!source) return [];
    const scopes = curves.get(run) ?? new WeakMap<Traces, Drawn<Underlay>>();
    curves.set(run, scopes);
    const drawn = scopes.get(scope);
    if (drawn?.source === source) return drawn.list;
    const list = tracesOf(run, scope).map((trace) => new GhostCurve(source, trace, dashOf(run)));
    scopes.set(scope, { source, list });
    return list;
  });
}

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
        ? [new GhostPath(source, variant, dashOf(run))]
        : [],
    );
    paths.set(run, { source, list });
    return list;
  });
}
