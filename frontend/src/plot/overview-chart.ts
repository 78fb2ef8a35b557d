/** A strip with the whole of a recording: where something happens, and which part is looked at. */

import { AxisScale } from './axis-scale';
import { crisp, type Canvas } from './canvas';
import { calmRange, type Range } from './range';
import { TIME, type Moment, type Trace } from './scope-chart';
import type { SampleSource } from './source';
import { SourceCurve } from './source-curve';

/** As the value axis of the scopes below it: time begins and ends at the same pixels. */
const LEFT = 66;
const EDGE = 3;
/** Least distance of the two handles, CSS pixels. */
const BRUSH = 6;
const MARK = 4;
const HANDLE = 6;

export interface OverviewState {
  whole: Range;
  range: Range;
  moments: readonly Moment[];
  /** The stretch that metrics are of. */
  window: Range | null;
  right: number;
}

export class OverviewChart {
  private readonly curves: SourceCurve[];
  private x: AxisScale;
  private drawn = '';

  constructor(
    private readonly canvas: Canvas,
    traces: readonly Trace[],
  ) {
    this.curves = traces.map((trace) => new SourceCurve(trace.column, { ...trace, width: 1 }));
    this.x = this.timeScale({ from: 0, to: 1 }, 0);
  }

  draw(source: SampleSource, { whole, range, moments, window, right }: OverviewState): void {
    const key = `${source.version} ${whole.from} ${whole.to} ${range.from} ${range.to} ${moments.length} ${window?.from} ${window?.to} ${right}`;
    if (key === this.drawn) return;
    this.drawn = key;
    const { canvas } = this;
    const { c, height, palette } = canvas;
    const x = (this.x = this.timeScale(whole, right));
    const [left, end] = x.pixels;
    const bins = source.cut(whole.from, whole.to, end - left);
    const extents = this.curves.map((curve) => curve.read(source, bins));
    const low = Math.min(...extents.map(([least]) => least));
    const high = Math.max(...extents.map(([, most]) => most));
    const { from, to } = calmRange(null, low, high);
    const y = new AxisScale(TIME, from, to, [height - EDGE, EDGE]);
    canvas.clear();
    canvas.pen('grid');
    canvas.lines([[left, crisp(height - 1), end, crisp(height - 1)]]);
    for (const curve of this.curves) curve.draw(canvas, source, x, y);
    if (window) {
      const [a, b] = [x.px(window.from), x.px(window.to)].map(crisp) as [number, number];
      canvas.pen('strong');
      canvas.lines([[a, 1.5, b, 1.5], [a, 1.5, a, 5], [b, 1.5, b, 5]]); // prettier-ignore
    }
    for (const { time } of moments) {
      if (time < whole.from || time > whole.to) continue;
      const at = x.px(time);
      canvas.pen('axis', 1, 'dot');
      canvas.lines([[crisp(at), 0, crisp(at), height]]);
      c.fillStyle = palette.axis;
      c.beginPath();
      c.moveTo(at, height - 2 * MARK);
      c.lineTo(at + MARK, height - MARK);
      c.lineTo(at, height);
      c.lineTo(at - MARK, height - MARK);
      c.fill();
    }
    const [a, b] = this.brush(range);
    // What is not looked at is dimmed.
    c.globalAlpha = 0.6;
    c.fillStyle = palette.well;
    c.fillRect(left, 0, a - left, height);
    c.fillRect(b, 0, end - b, height);
    c.globalAlpha = 1;
    canvas.pen('focus', 1);
    c.strokeRect(crisp(a), 0.5, Math.max(1, Math.round(b - a)), height - 1);
    c.fillStyle = palette.focus;
    for (const at of [a, b]) c.fillRect(at - 1.5, height / 2 - 6, 4, 12);
  }

  time(px: number): number {
    const [left, end] = this.x.pixels;
    return this.x.at(Math.min(end, Math.max(left, px)));
  }

  /** What a pointer takes hold of. */
  at(px: number, range: Range): 'from' | 'to' | 'middle' | 'outside' {
    const [a, b] = this.brush(range);
    if (Math.abs(px - a) <= HANDLE && Math.abs(px - a) <= Math.abs(px - b)) return 'from';
    if (Math.abs(px - b) <= HANDLE) return 'to';
    return px > a && px < b ? 'middle' : 'outside';
  }

  /** The moment whose mark is at a pixel. */
  moment(px: number, moments: readonly Moment[]): Moment | null {
    return moments.find(({ time }) => Math.abs(this.x.px(time) - px) <= MARK + 1) ?? null;
  }

  private brush({ from, to }: Range): [number, number] {
    const [left, end] = this.x.pixels;
    const clip = (px: number) => Math.min(end, Math.max(left, px));
    const [a, b] = [clip(this.x.px(from)), clip(this.x.px(to))];
    const room = Math.max(0, BRUSH - (b - a)) / 2;
    return [a - room, b + room];
  }

  private timeScale({ from, to }: Range, right: number): AxisScale {
    const across = Math.max(1, this.canvas.width - LEFT - right);
    return new AxisScale(TIME, from, to, [LEFT, LEFT + across]);
  }
}
