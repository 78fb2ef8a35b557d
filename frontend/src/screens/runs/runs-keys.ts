/** Keys of the Runs screen. */

import type { KeyTable } from '../../parts/shell/keyboard.svelte';
import { app } from '../../app/store.svelte';
import { actions } from './actions.svelte';
import { overlaySelected } from './run-actions';
import { baseline } from './baseline.svelte';
import { comparison } from './compare/comparison.svelte';
import { plots } from './plots';
import { replays } from './replays/replays.svelte';
import { runs } from './runs.svelte';

/** Rows of a page. */
const PAGE = 10;

export const RUNS_KEYS: KeyTable = {
  title: 'Runs',
  keys: [
    { keys: '/', does: 'Search' },
    { keys: '↑ ↓', does: 'Previous, next run; with shift select on the way' },
    { keys: 'PgUp, PgDn', does: 'Ten runs further up, down' },
    { keys: 'Space', does: 'Select, or clear the selection' },
    { keys: 'Ctrl+A', does: 'Select all that are listed' },
    { keys: 'Enter', does: 'Open over the whole width; others that are selected lie behind it' },
    { keys: 'o', does: 'Overlay in the Lab' },
    { keys: 'i', does: 'Import a measurement' },
    { keys: 'w', does: 'What changed: runs that are simulated again, or close it' },
    { keys: 'c', does: 'Compare two selected runs, or one with the baseline' },
    { keys: 's', does: 'Swap 1 and 2 of a comparison' },
    { keys: '[ ]', does: 'Previous, next place beyond tolerance' },
    { keys: 'b', does: 'Baseline of the list: this run, or none' },
    { keys: 'p', does: 'Pin' },
    { keys: 't', does: 'Tag, in place of light or dark' },
    { keys: 'Del', does: 'Delete; a notice offers Undo' },
    { keys: '+ −', does: 'Zoom the curves of the run' },
    { keys: ', .', does: 'Move along the curves' },
    { keys: 'k, K', does: 'Cursor to the next peak of the curves, or the one before' },
    { keys: '0', does: 'The whole run' },
  ],
};

/** Returns what the keys do; what opens parts of the screen is given by it. */
export function runsActions(
  search: () => void,
  open: () => void,
  importFile: () => void,
): Record<string, () => void> {
  const some = () => runs.selected.filter((run) => run.deleted === null);
  const peak = (way: 1 | -1) => void app.try(async () => plots.current?.nextPeak?.(way));
  const zoom = (ratio: number) => plots.current?.zoomBy(ratio);
  return {
    '/': search,
    Enter: open,
    o: overlaySelected,
    i: importFile,
    w: () => replays.toggle(),
    c: () => (comparison.pair ? comparison.close() : comparison.open()),
    s: () => comparison.swap(),
    '[': () => plots.current?.excursion?.(-1),
    ']': () => plots.current?.excursion?.(1),
    b: () => {
      const [run, ...more] = some();
      if (run && more.length === 0) baseline.toggle(run);
    },
    p: () => void runs.pin(some()),
    t: () => actions.open('tag'),
    Delete: () => void (some().length > 0 && runs.remove(some())),
    ' ': () => runs.choose(runs.selection.at, 'toggle'),
    '+': () => zoom(0.5),
    '=': () => zoom(0.5),
    '-': () => zoom(2),
    ',': () => plots.current?.moveBy(-0.25),
    '.': () => plots.current?.moveBy(0.25),
    k: () => peak(1),
    K: () => peak(-1),
    '0': () => plots.current?.reset(),
  };
}

/** Moves through the list; whether the key was one of these. */
export function listKey(event: KeyboardEvent): boolean {
  if ((event.ctrlKey || event.metaKey) && event.key === 'a') {
    runs.chooseAll();
    return true;
  }
  const way: Record<string, number> = {
    ArrowUp: -1,
    ArrowDown: 1,
    PageUp: -PAGE,
    PageDown: PAGE,
    Home: Number.NEGATIVE_INFINITY,
    End: Number.POSITIVE_INFINITY,
  };
  const by = way[event.key];
  if (by === undefined || event.ctrlKey || event.metaKey || event.altKey) return false;
  runs.move(by, event.shiftKey);
  return true;
}
