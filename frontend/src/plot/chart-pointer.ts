/** From the pointer on a chart over time to zoom and cursors, in time and in value. */

import type { AxisScale } from './axis-scale';
import { timeAt, type Range } from './range';

/** A pointer that moves less than this between down and up has clicked, CSS pixels. */
const CLICK = 4;
/** Zoom of a value axis by the wheel. */
const WHEEL = 1.002;

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
  /** Other ends of the value axis; null where it is to follow the data again. */
  hold?(ends: readonly [number, number] | null): void;
  /** A click beside the value axis with Shift: a cursor is to be set at that value. */
  setLevel?(value: number): void;
}

/** Data for the pointer of the chart drawn last. */
export interface TimeAxis {
  readonly range: Range;
  readonly cursors: readonly number[];
  /** First and last pixel of the axis. */
  readonly ends: readonly [number, number];
  readonly y: AxisScale;
}

export class ChartPointer {
  /** Where a button went down, CSS pixels. */
  private pressed: number | null = null;
  /** The cursor that is dragged, or -1. */
  private dragged = -1;
  /** Where a drag of the value axis began, and its ends then. */
  private lifted: { at: number; y: AxisScale } | null = null;
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
    canvas.addEventListener('dblclick', (event) => this.double(event), { signal });
    canvas.addEventListener('wheel', (event) => this.wheel(event), { signal, passive: false });
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

  /** Whether a pixel is beside the value axis, where that is zoomed and moved. */
  private beside(x: number): boolean {
    return this.events.hold !== undefined && x < this.axis.ends[0];
  }

  private down(event: PointerEvent): void {
    if (event.button !== 0) return;
    if (this.beside(event.offsetX)) {
      this.canvas.setPointerCapture(event.pointerId);
      this.lifted = { at: event.offsetY, y: this.axis.y };
    }
    if (event.offsetX < this.axis.ends[0]) return;
    this.canvas.setPointerCapture(event.pointerId);
    this.dragged = this.cursorAt(event.offsetX);
    if (this.dragged < 0) this.pressed = event.offsetX;
  }

  private move({ offsetX: x, offsetY }: PointerEvent): void {
    const { pressed, dragged: cursor, lifted } = this;
    if (lifted) {
      if (Math.abs(offsetY - lifted.at) >= CLICK) {
        const { y } = lifted;
        const by = y.at(lifted.at) - y.at(offsetY);
        this.events.hold?.([y.from + by, y.to + by]);
      }
      return;
    }
    const [first, last] = this.axis.ends;
    if (cursor >= 0) this.events.drag(cursor, this.time(x));
    else if (this.beside(x)) this.canvas.style.cursor = 'ns-resize';
    else this.canvas.style.cursor = this.cursorAt(x) < 0 ? '' : 'ew-resize';
    if (pressed === null && (x < first || x > last)) return this.leave();
    const dragged = pressed !== null && Math.abs(x - pressed) >= CLICK;
    this.events.point({ at: this.share(x), since: dragged ? this.share(pressed) : null });
  }

  private up({ offsetX: x, offsetY, shiftKey }: PointerEvent): void {
    const { pressed, lifted } = this;
    this.dragged = -1;
    this.lifted = null;
    if (lifted && shiftKey && Math.abs(offsetY - lifted.at) < CLICK) {
      this.events.setLevel?.(lifted.y.at(offsetY));
    }
    if (pressed === null) return;
    this.pressed = null;
    this.events.point({ at: this.share(x), since: null });
    const [from, to] = [this.time(Math.min(x, pressed)), this.time(Math.max(x, pressed))];
    if (Math.abs(x - pressed) < CLICK) this.events.set(to);
    else this.events.zoom({ from, to });
  }

  private double({ offsetX }: MouseEvent): void {
    if (this.beside(offsetX)) this.events.hold?.(null);
    else this.events.reset();
  }

  /** Over the value axis the wheel zooms that; elsewhere it goes on to the time axis. */
  private wheel(event: WheelEvent): void {
    if (!this.beside(event.offsetX)) return;
    event.preventDefault();
    event.stopPropagation();
    const { y } = this.axis;
    const centre = y.at(event.offsetY);
    const ratio = WHEEL ** event.deltaY;
    this.events.hold?.([centre - (centre - y.from) * ratio, centre + (y.to - centre) * ratio]);
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
    this.lifted = null;
    this.events.point(null);
  }
}
