/** From the pointer on a chart over time to zoom and cursors. */

import { timeAt, type Range } from './range';

/** A pointer that moves less than this between down and up has clicked, CSS pixels. */
const CLICK = 4;

/** Where a pointer is, and where its drag began, as shares of the time axis. */
export interface Pointer {
  at: number;
  since: number | null;
}

export interface ChartEvents {
  zoom(range: Range): void;
  reset(): void;
  /** A click: a cursor is to be set. */
  set(time: number): void;
  drag(cursor: number, time: number): void;
  point(pointer: Pointer | null): void;
}

/** Data for the pointer of the chart drawn last. */
export interface TimeAxis {
  readonly range: Range;
  readonly cursors: readonly number[];
  /** First and last pixel of the axis. */
  readonly ends: readonly [number, number];
}

export class ChartPointer {
  /** Where a button went down, CSS pixels. */
  private pressed: number | null = null;
  /** The cursor that is dragged, or -1. */
  private dragged = -1;
  private readonly stop = new AbortController();

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly axis: TimeAxis,
    private readonly events: ChartEvents,
  ) {
    const { signal } = this.stop;
    canvas.addEventListener('pointerdown', (event) => this.down(event), { signal });
    canvas.addEventListener('pointermove', (event) => this.move(event), { signal });
    canvas.addEventListener('pointerup', (event) => this.up(event), { signal });
    canvas.addEventListener('pointerleave', () => this.leave(), { signal });
    canvas.addEventListener('pointercancel', () => this.leave(), { signal });
    canvas.addEventListener('dblclick', () => events.reset(), { signal });
  }

  destroy(): void {
    this.stop.abort();
    this.events.point(null);
  }

  /** Share of the time axis at a pixel. */
  private share(x: number): number {
    const [first, last] = this.axis.ends;
    return Math.min(1, Math.max(0, (x - first) / (last - first)));
  }

  private time(x: number): number {
    return timeAt(this.axis.range, this.share(x));
  }

  private down(event: PointerEvent): void {
    if (event.button !== 0 || event.offsetX < this.axis.ends[0]) return;
    this.canvas.setPointerCapture(event.pointerId);
    this.dragged = this.cursorAt(event.offsetX);
    if (this.dragged < 0) this.pressed = event.offsetX;
  }

  private move({ offsetX: x }: PointerEvent): void {
    const { pressed, dragged: cursor } = this;
    const [first, last] = this.axis.ends;
    if (cursor >= 0) this.events.drag(cursor, this.time(x));
    else this.canvas.style.cursor = this.cursorAt(x) < 0 ? '' : 'ew-resize';
    if (pressed === null && (x < first || x > last)) return this.leave();
    const dragged = pressed !== null && Math.abs(x - pressed) >= CLICK;
    this.events.point({ at: this.share(x), since: dragged ? this.share(pressed) : null });
  }

  private up({ offsetX: x }: PointerEvent): void {
    const { pressed } = this;
    this.dragged = -1;
    if (pressed === null) return;
    this.pressed = null;
    this.events.point({ at: this.share(x), since: null });
    const [from, to] = [this.time(Math.min(x, pressed)), this.time(Math.max(x, pressed))];
    if (Math.abs(x - pressed) < CLICK) this.events.set(to);
    else this.events.zoom({ from, to });
  }

  /** The cursor that a pointer can take hold of, or -1. */
  private cursorAt(x: number): number {
    const { range, cursors, ends } = this.axis;
    const perSecond = (ends[1] - ends[0]) / (range.to - range.from);
    return cursors.findIndex(
      (time) => Math.abs(ends[0] + (time - range.from) * perSecond - x) <= CLICK,
    );
  }

  private leave(): void {
    this.pressed = null;
    this.dragged = -1;
    this.events.point(null);
  }
}
