/** Curves of another run, behind the present ones: hue and dashes of the run, B the bolder line. */

import type { AxisScale } from './axis-scale';
import type { Canvas } from './canvas';
import type { Plane } from './plane';
import type { Range } from './range';
import type { SampleSource } from './source';
import { SourceCurve } from './source-curve';
import type { Trace, Traces } from './scope-chart';
import type { Dash, Look } from './types';
import { RUN_INKS } from './palette';

export interface Underlay {
  /** Changes whenever there is something new to draw; no two share one. */
  readonly version: number;
  /** The column of the curve that it lies behind, whose value axis it shares. */
  readonly column: string;
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

export const STRENGTH = 0.8;
const [THIN, BOLD] = [1.25, 2];
/** Bins for each pixel: what lies behind is drawn for half the price. */
const COARSER = 0.5;

export class GhostCurve implements Underlay {
  readonly version = nextVersion();
  readonly column: string;
  private readonly curve: SourceCurve;

  constructor(
    private readonly source: SampleSource,
    { column, ink = 'text' }: Trace,
    look: Dash | Look,
  ) {
    this.column = column;
    this.curve = new SourceCurve(column, { ink, width: 1.25, ...looked(look) });
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

export const looked = (look: Dash | Look): Look =>
  typeof look === 'string' ? { dash: look } : look;

const DASHES: readonly Dash[] = ['long', 'dot', 'dashdot', 'dash'];

export interface GhostRun {
  readonly shown: boolean;
  /** Tells it from the others: 0 to 3. */
  readonly slot: number;
  has(column: string): boolean;
  /** Its curves over a stretch of time of what it lies behind. */
  over(range: Range): SampleSource | null;
}

export interface Drawn<T> {
  source: SampleSource;
  list: readonly T[];
}

const curves = new WeakMap<GhostRun, WeakMap<Traces, Drawn<Underlay>>>();

/** The look of a run, in legends and lists: whichever else are drawn, it keeps its own. */
export function lookOf({ slot }: Pick<GhostRun, 'slot'>): Look {
  return { ink: RUN_INKS[slot] ?? 'text', dash: DASHES[slot] ?? 'long', width: 2 };
}

/** The same of one of its variants: B is the bolder line. */
export function lookOfVariant(run: GhostRun, variant: string): Look {
  return { ...lookOf(run), width: variant === 'B' ? BOLD : THIN };
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
    const list = tracesOf(run, scope).map(
      (trace) => new GhostCurve(source, trace, lookOfVariant(run, trace.column.charAt(0))),
    );
    scopes.set(scope, { source, list });
    return list;
  });
}
