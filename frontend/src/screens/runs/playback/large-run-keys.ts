/** Keys of a run over the whole width. */

import type { KeyTable } from '../../../parts/shell/keyboard.svelte';
import { app } from '../../../app/store.svelte';
import { overlayInLab } from '../run-actions';
import { large } from './large.svelte';
import type { PlayedCurves } from './played-curves.svelte';

export const LARGE_KEYS: KeyTable = {
  title: 'One run',
  keys: [
    { keys: 'Space', does: 'Play or pause' },
    { keys: '← →', does: 'Back, on by 1 % of what is visible' },
    { keys: '< >', does: 'Back, on by one sample' },
    { keys: 'Home, End', does: 'Begin, end of the run' },
    { keys: '[ ]', does: 'Slower, faster' },
    { keys: '1 to 9', does: 'Give a scope the whole height, or back' },
    { keys: 'n', does: 'New scope: choose its channels' },
    { keys: 'j, J', does: 'Jump to the next mark on the time axis, or the one before' },
    { keys: 'k, K', does: 'Go to the next peak of a trace, or the one before' },
    { keys: 'M', does: 'All readings as a table' },
    { keys: '+ −', does: 'Zoom about the pointer or the middle' },
    { keys: ', .', does: 'Move along the curves' },
    { keys: '0', does: 'The whole run' },
    { keys: 'o', does: 'Overlay in the Lab' },
    { keys: 'Enter', does: 'Back to the list' },
  ],
};

export function largeActions(): Record<string, () => void> {
  const on = (act: (curves: PlayedCurves) => void) => () => {
    if (large.curves) act(large.curves);
  };
  const scopes = Array.from(
    { length: 9 },
    (_, i) => [String(i + 1), on((curves) => curves.layout.forward(i))] as const,
  );
  return {
    ...Object.fromEntries(scopes),
    ' ': on((curves) => curves.playOrPause()),
    ArrowLeft: on((curves) => curves.step(-1)),
    ArrowRight: on((curves) => curves.step(1)),
    '<': on((curves) => curves.stepSamples(-1)),
    '>': on((curves) => curves.stepSamples(1)),
    Home: on((curves) => curves.seek(0)),
    End: on((curves) => curves.seek(curves.end)),
    '[': on((curves) => curves.faster(-1)),
    ']': on((curves) => curves.faster(1)),
    '+': on((curves) => curves.zoomBy(0.5)),
    '=': on((curves) => curves.zoomBy(0.5)),
    '-': on((curves) => curves.zoomBy(2)),
    ',': on((curves) => curves.moveBy(-0.25)),
    '.': on((curves) => curves.moveBy(0.25)),
    '0': on((curves) => curves.reset()),
    n: on((curves) => (curves.layout.choosing = curves.layout.scopes.length)),
    j: on((curves) => curves.nextMoment(1)),
    J: on((curves) => curves.nextMoment(-1)),
    k: on((curves) => void app.try(() => curves.nextPeak(1))),
    K: on((curves) => void app.try(() => curves.nextPeak(-1))),
    M: on((curves) => (curves.measuring = !curves.measuring)),
    o: () => overlayInLab([large.id]),
    Enter: () => large.close(),
  };
}
