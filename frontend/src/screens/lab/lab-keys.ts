/** What the keys of the Lab screen do; lab-key-table.ts says it. */

import { app } from '../../app/store.svelte';
import { moveLaw } from './gains/move-law';
import { onDemand } from './on-demand.svelte';
import { scene } from './scene3d/scene.svelte';
import { view } from './scopes/view.svelte';

const FASTER = 1.25;
/** Share of the time axis. */
const CURSOR_STEP = 0.005;
export const LONG_STEP = 200;

/** Returns what the keys of the Lab do. */
export function labActions(): Record<string, () => void> {
  const { session } = app;
  const drive = onDemand.drive?.driveRuns.machine === 'drive' ? onDemand.drive.driveRuns : null;
  const speed = (factor: number) => {
    void app.try(() => session.setSpeed(session.speed * factor));
  };
  const scopes = Array.from(
    { length: 9 },
    (_, i) => [String(i + 1), () => view.layout.forward(i)] as const,
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
    b: () => void moveLaw('back'),
    B: () => void moveLaw('forward'),
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
    F: () => (scene.tab === 'view3d' ? scene.fill() : void (view.filled = !view.filled)),
    c: () => void (scene.tab === 'view3d' && scene.nextCamera()),
    f: () => view.setAutomatic(!view.automatic),
  };
}
