/** From pointer and keys on the plane to changes of the path. */

import { inserted, moved, removed, shifted, snap, type DrawnPath, type Point } from './drawn-path';
import type { Editor } from './editor.svelte';
import { clickable, edgeAt, pointAt } from './geometry';
import type { PathView } from './path-view';

/** How near the pointer has to come, CSS pixels. */
const REACH = { mouse: 9, touch: 22 };
const EDGE_REACH = 6;
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
  | { what: 'view'; from: Point };

export class Hand {
  /** The view as last made, for the next one of another theme. */
  last: PathView | null = null;
  /** Whether the view has moved since it was drawn. */
  moved = false;
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
    if (!path) {
      this.grip = { what: 'view', from: at };
      return;
    }
    if (editor.tool === 'move' || event.shiftKey) {
      this.grip = { what: 'all', from: at, path };
      return;
    }
    const reach = (event.pointerType === 'touch' ? REACH.touch : REACH.mouse) / view.scale;
    const index = pointAt(path.points, at, reach);
    if (index !== null) {
      const [x, y] = path.points[index] as Point;
      editor.selected = index;
      this.grip = { what: 'point', index, offset: [x - at[0], y - at[1]] };
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
        const way = ([0, 1] as const).map((axis) =>
          snap(at[axis] - grip.from[axis], editor.step),
        ) as [number, number];
        editor.edit(shifted(grip.path, way), this.gesture);
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
    this.grip = null;
    this.editor.rest();
  }

  double(event: MouseEvent): void {
    const { editor } = this;
    const view = this.view();
    if (!view || !editor.path || editor.tool === 'add') return;
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
    const { path, selected } = editor;
    if (!path || event.ctrlKey || event.metaKey || event.altKey) return;
    const way = ARROWS[event.key];
    if (way) {
      event.preventDefault();
      const step = event.shiftKey ? NUDGE.shift : NUDGE.plain;
      const by: Point = [way[0] * step, way[1] * step];
      const point = selected === null ? undefined : path.points[selected];
      if (selected === null || !point) editor.edit(shifted(path, by), 'nudge all');
      else {
        const to: Point = [point[0] + by[0], point[1] + by[1]];
        editor.edit(moved(path, selected, to), `nudge ${selected}`);
      }
    } else if (event.key === 'Tab') {
      this.tab(event, path, selected);
    } else if ((event.key === 'Delete' || event.key === 'Backspace') && selected !== null) {
      event.preventDefault();
      editor.edit(removed(path, selected));
      editor.selected = path.points.length > 1 ? Math.max(0, selected - 1) : null;
    } else if (event.key === 'Insert' && selected !== null) {
      event.preventDefault();
      insertAfter(editor, selected);
    }
  }

  /** Goes from point to point; past the last one the focus leaves the plane. */
  private tab(event: KeyboardEvent, path: DrawnPath, selected: number | null): void {
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
