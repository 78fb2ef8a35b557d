/** From pointer and keys on the plane to changes of the path. */

import {
  inserted,
  moved,
  newPath,
  shifted,
  snap,
  withoutPoints,
  type DrawnPath,
  type Point,
} from './drawn-path';
import type { Editor } from './editor.svelte';
import { drawn } from './shapes';
import { clickable, distance, edgeAt, pointAt } from './geometry';
import type { PathView } from './path-view';
import { movedBy, within } from './selection';

/** How near the pointer has to come, CSS pixels. */
const REACH = { mouse: 9, touch: 22 };
const EDGE_REACH = 6;
/** Of a stroke: distance of its places, of those left out from its chords, of its end from its start. */
const STROKE = { apart: 2, tolerance: 1.5, closing: 14 };
const ZOOM_STEP = 1.0015;
const NUDGE = { plain: 1e-3, shift: 1e-4 };
const ARROWS: Record<string, Point> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowDown: [0, -1],
  ArrowUp: [0, 1],
};

type Grip =
  | { what: 'point'; index: number; offset: Point }
  | { what: 'all'; from: Point; path: DrawnPath }
  | { what: 'chosen'; from: Point; path: DrawnPath }
  | { what: 'band'; from: Point; before: ReadonlySet<number> }
  | { what: 'draw' }
  | { what: 'view'; from: Point };

export class PlaneGesture {
  /** The view as last made, for the next one of another theme. */
  last: PathView | null = null;
  /** Whether the view has moved since it was drawn. */
  moved = false;
  /** Two corners of the box in which points are being chosen. */
  band: readonly [Point, Point] | null = null;
  /** What is being drawn. */
  sketch: Point[] | null = null;
  private grip: Grip | null = null;
  private gestures = 0;

  constructor(
    private readonly editor: Editor,
    private readonly view: () => PathView | null,
  ) {}

  down(event: PointerEvent): void {
    const { editor } = this;
    const view = this.view();
    if (!view || event.button !== 0) return;
    const surface = event.currentTarget as HTMLElement;
    surface.setPointerCapture(event.pointerId);
    this.gestures += 1;
    editor.rest();
    const at = view.place(pixels(event));
    const { path } = editor;
    if (editor.tool === 'draw') {
      [this.grip, this.sketch] = [{ what: 'draw' }, [at]];
      return;
    }
    if (!path) {
      this.grip = { what: 'view', from: at };
      return;
    }
    if (editor.tool === 'move') {
      this.grip = { what: 'all', from: at, path };
      return;
    }
    const reach = (event.pointerType === 'touch' ? REACH.touch : REACH.mouse) / view.scale;
    const index = pointAt(path.points, at, reach);
    if (index !== null) {
      this.take(path, index, at, event.shiftKey);
      return;
    }
    if (editor.tool === 'select' || event.shiftKey) {
      const before = event.shiftKey ? editor.chosen : new Set<number>();
      editor.chosen = before;
      this.grip = { what: 'band', from: at, before };
      return;
    }
    const edge = edgeAt(clickable(path, editor.outline), at, EDGE_REACH / view.scale);
    if (edge) {
      this.add(path, edge.edge + 1, edge.place);
    } else if (editor.tool === 'add') {
      this.append(path, at);
    } else {
      editor.selected = null;
      this.grip = { what: 'view', from: at };
    }
  }

  /** Takes hold of a point, and of the others that are chosen with it. */
  private take(path: DrawnPath, index: number, at: Point, more: boolean): void {
    const { editor } = this;
    const { chosen } = editor;
    if (more) {
      const others = [...chosen].filter((each) => each !== index);
      editor.chosen = new Set(chosen.has(index) ? others : [...others, index]);
    } else if (chosen.size > 1 && chosen.has(index)) {
      this.grip = { what: 'chosen', from: at, path };
    } else {
      const [x, y] = path.points[index] as Point;
      editor.selected = index;
      this.grip = { what: 'point', index, offset: [x - at[0], y - at[1]] };
    }
  }

  move(event: PointerEvent): void {
    const { editor, grip } = this;
    const view = this.view();
    if (!view || !grip) return;
    const at = view.place(pixels(event));
    switch (grip.what) {
      case 'view':
        view.pan([grip.from[0] - at[0], grip.from[1] - at[1]]);
        this.moved = true;
        return;
      case 'all': {
        editor.edit(shifted(grip.path, this.way(grip.from, at)), this.gesture);
        return;
      }
      case 'chosen':
        editor.edit(movedBy(grip.path, editor.chosen, this.way(grip.from, at)), this.gesture);
        return;
      case 'band': {
        this.band = [grip.from, at];
        const enclosed = editor.path ? within(editor.path, grip.from, at) : [];
        editor.chosen = new Set([...grip.before, ...enclosed]);
        this.moved = true;
        return;
      }
      case 'draw': {
        const last = this.sketch?.at(-1);
        if (!last || distance(last, at) * view.scale < STROKE.apart) return;
        this.sketch?.push(at);
        this.moved = true;
        return;
      }
      case 'point': {
        const { path } = editor;
        if (!path) return;
        const to = this.snapped([at[0] + grip.offset[0], at[1] + grip.offset[1]]);
        editor.edit(moved(path, grip.index, to), this.gesture);
        return;
      }
      default:
        grip satisfies never;
    }
  }

  up(event: PointerEvent): void {
    (event.currentTarget as HTMLElement).releasePointerCapture(event.pointerId);
    if (event.type !== 'pointercancel') this.finish();
    [this.grip, this.band, this.sketch] = [null, null, null];
    this.moved = true;
    this.editor.rest();
  }

  /** Makes a path of what was drawn; its timing stays. */
  private finish(): void {
    const { editor, sketch } = this;
    const view = this.view();
    if (!view || !sketch) return;
    const { points, closed } = drawn(
      sketch,
      STROKE.tolerance / view.scale,
      STROKE.closing / view.scale,
    );
    if (points.length < 2) return;
    const timed = editor.path ?? newPath([], false);
    const laps = closed ? timed.laps : 1;
    editor.edit({ ...timed, points, closed, laps, geometry: 'spline', corners: [] });
    editor.selected = null;
  }

  double(event: MouseEvent): void {
    const { editor } = this;
    const view = this.view();
    if (!view || !editor.path || editor.tool !== 'edit') return;
    const at = view.place([event.offsetX, event.offsetY]);
    if (pointAt(editor.path.points, at, REACH.mouse / view.scale) !== null) return;
    this.append(editor.path, at);
    this.grip = null;
    editor.rest();
  }

  wheel(event: WheelEvent): void {
    const view = this.view();
    if (!view) return;
    event.preventDefault();
    view.zoomAt([event.offsetX, event.offsetY], ZOOM_STEP ** -event.deltaY);
    this.moved = true;
  }

  fit(points: readonly Point[]): void {
    this.view()?.fit(points);
    this.moved = true;
  }

  key(event: KeyboardEvent): void {
    const { editor } = this;
    const { path, selected, chosen } = editor;
    if (!path || event.altKey) return;
    if (event.ctrlKey || event.metaKey) {
      if (event.key.toLowerCase() !== 'a') return;
      event.preventDefault();
      editor.chosen = new Set(path.points.keys());
      return;
    }
    const way = ARROWS[event.key];
    if (way) {
      event.preventDefault();
      const step = event.shiftKey ? NUDGE.shift : NUDGE.plain;
      const by: Point = [way[0] * step, way[1] * step];
      if (chosen.size === 0) editor.edit(shifted(path, by), 'nudge all');
      else editor.edit(movedBy(path, chosen, by), `nudge ${[...chosen].join()}`);
    } else if (event.key === ']' || event.key === '[') {
      this.more(event, path);
    } else if (event.key === 'Tab') {
      this.tab(event, path, selected);
    } else if ((event.key === 'Delete' || event.key === 'Backspace') && selected !== null) {
      event.preventDefault();
      editor.edit(withoutPoints(path, chosen));
      const left = path.points.length - chosen.size;
      const before = Math.max(0, Math.min(left - 1, selected - 1));
      editor.selected = left > 0 && chosen.size === 1 ? before : null;
    } else if (event.key === 'Insert' && selected !== null) {
      event.preventDefault();
      insertAfter(editor, selected);
    }
  }

  /** Selects the point after the last one too, or the last one no longer. */
  private more(event: KeyboardEvent, path: DrawnPath): void {
    const { editor } = this;
    event.preventDefault();
    const all = [...editor.chosen];
    const count = path.points.length;
    const next = ((all.at(-1) ?? -1) + 1) % Math.max(1, count);
    if (event.key === '[') all.pop();
    else if (count > 0) all.push(next);
    editor.chosen = new Set(all);
  }

  /** Goes from point to point; past the last one, or from several to their tools, the focus leaves. */
  private tab(event: KeyboardEvent, path: DrawnPath, selected: number | null): void {
    if (this.editor.chosen.size > 1) return;
    const count = path.points.length;
    const next = event.shiftKey
      ? selected === null
        ? -1
        : selected - 1
      : selected === null
        ? 0
        : selected + 1;
    if (next < 0 || next >= count) {
      this.editor.selected = null;
      return;
    }
    event.preventDefault();
    this.editor.selected = next;
  }

  private append(path: DrawnPath, at: Point): void {
    const line = clickable(path, this.editor.outline);
    const edge = path.closed ? edgeAt(line, at, Number.POSITIVE_INFINITY) : null;
    this.add(path, edge ? edge.edge + 1 : path.points.length, at);
  }

  private add(path: DrawnPath, index: number, at: Point): void {
    const { editor } = this;
    const to = this.snapped(at);
    editor.edit(inserted(path, index, to), this.gesture);
    editor.selected = index;
    this.grip = { what: 'point', index, offset: [to[0] - at[0], to[1] - at[1]] };
  }

  /** Returns how far the hand has come, on the grid. */
  private way(from: Point, to: Point): Point {
    return [snap(to[0] - from[0], this.editor.step), snap(to[1] - from[1], this.editor.step)];
  }

  private snapped([x, y]: Point): Point {
    return [snap(x, this.editor.step), snap(y, this.editor.step)];
  }

  private get gesture(): string {
    return `drag ${this.gestures}`;
  }
}

/** Adds a point half-way to the next one. */
export function insertAfter(editor: Editor, index: number): void {
  const { path } = editor;
  const here = path?.points[index];
  if (!path || !here) return;
  const next = path.points[index + 1] ?? (path.closed ? path.points[0] : undefined);
  const at: Point = next
    ? [(here[0] + next[0]) / 2, (here[1] + next[1]) / 2]
    : [here[0] + 0.01, here[1]];
  editor.edit(inserted(path, index + 1, at));
  editor.selected = index + 1;
}

function pixels(event: PointerEvent): Point {
  return [event.offsetX, event.offsetY];
}
