/** Keys of the Lab screen. */

import type { KeyTable } from '../../parts/shell/keyboard.svelte';
import { app } from '../../app/store.svelte';
import { onDemand } from './on-demand.svelte';
import { scene } from './scene3d/scene.svelte';
import { view } from './scopes/view.svelte';

const FASTER = 1.25;
/** Share of the time axis. */
const CURSOR_STEP = 0.005;
export const LONG_STEP = 200;

export const LAB_KEYS: KeyTable = {
  title: 'Lab',
  keys: [
    { keys: 'Space', does: 'Play or pause' },
    { keys: 's, S', does: 'Step one tick (0.5 ms), or 100 ms' },
    { keys: 'r', does: 'Reset to 0 s' },
    { keys: '[ ]', does: 'Slower, faster' },
    { keys: 'w, l', does: 'Staged, in the motor' },
    { keys: 'u', does: 'Undo the last change' },
    { keys: 'a', does: 'Send what is staged to the motor' },
    { keys: '1 to 9', does: 'Give a scope the whole height, or back' },
    { keys: 'n', does: 'New scope: choose its channels' },
    { keys: '/', does: 'Find a channel for the first scope' },
    { keys: '+ −', does: 'Zoom the time axis about the pointer or its middle' },
    { keys: ', .', does: 'Move the time axis' },
    { keys: 'j, J', does: 'Jump to the next mark on the time axis, or the one before' },
    { keys: 'k, K', does: 'Cursor to the next peak of a trace, or the one before' },
    { keys: 'm', does: 'Set cursor 1, then cursor 2, then clear both' },
    { keys: 'V', does: 'Cursors at the least and the largest value' },
    { keys: 'M', does: 'All readings as a table' },
    { keys: '< >', does: 'Move the cursor that was set last' },
    { keys: 'h, H', does: 'Trigger: arm it, or find hits; off' },
    { keys: 'v', does: 'Readings tell the value, mean, RMS, peak to peak, std' },
    { keys: '0', does: 'Reset zoom and cursors' },
    { keys: 'o', does: 'Overlay runs' },
    { keys: 'F', does: '3-D view over the whole page, or back' },
    { keys: 'c', does: 'Next camera of the 3-D view' },
    { keys: 'f', does: 'Value axes follow the data, or hold' },
  ],
};

/** While the 3-D view has the focus; all other keys of the Lab act there too. */
export const SCENE_KEYS: KeyTable = {
  title: '3-D view',
  keys: [
    {
      keys: 'w a s d q e',
      does: 'Move the camera (Tab into the view first), in place of w, a and s',
    },
    { keys: 'Arrows', does: 'Turn the camera' },
  ],
};

/** Returns what the keys of the Lab do. */
export function labActions(): Record<string, () => void> {
  const { session } = app;
  const drive = onDemand.drive?.driveRuns.machine === 'drive' ? onDemand.drive.driveRuns : null;
  const speed = (factor: number) => {
    void app.try(() => session.setSpeed(session.speed * factor));
  };
  const scopes = Array.from(
    { length: 9 },
    (_, i) => [String(i + 1), () => view.layout.maximise(i)] as const,
  );
  return {
    ...Object.fromEntries(scopes),
    ' ': () => void (drive ? app.try(() => drive.run()) : app.playOrPause()),
    s: () => void app.step(1),
    S: () => void app.step(LONG_STEP),
    r: () => void app.reset(),
    '[': () => speed(1 / FASTER),
    ']': () => speed(FASTER),
    w: () => app.setMode('whatif'),
    l: () => app.setMode('live'),
    u: () => void (app.undo.possible && app.undo.run()),
    a: () => void (app.pending > 0 && app.apply()),
    '0': () => view.reset(),
    '+': () => view.zoomBy(0.5),
    '=': () => view.zoomBy(0.5),
    '-': () => view.zoomBy(2),
    ',': () => view.moveBy(-0.25),
    '.': () => view.moveBy(0.25),
    m: () => view.placeCursor(),
    h: () => {
      view.trigger.open = true;
      view.trigger.arm();
    },
    H: () => view.trigger.stop(),
    M: () => (view.measuring = !view.measuring),
    V: () => view.placeLevels(),
    n: () => (view.layout.choosing = view.layout.scopes.length),
    '/': () => (view.layout.choosing = view.scopes[0]?.place ?? 0),
    j: () => view.nextMoment(1),
    J: () => view.nextMoment(-1),
    k: () => void app.try(() => view.nextPeak(1)),
    K: () => void app.try(() => view.nextPeak(-1)),
    '<': () => view.nudgeCursor(-CURSOR_STEP),
    '>': () => view.nudgeCursor(CURSOR_STEP),
    v: () => view.nextStatistic(),
    o: () => void onDemand.chooseRuns(),
    F: () => scene.fill(),
    c: () => void (scene.tab === 'view3d' && scene.nextCamera()),
    f: () => view.setAutomatic(!view.automatic),
  };
}
