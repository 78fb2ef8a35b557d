/** Keys of the whole page and of the Lab screen; the help sheet lists the same tables. */

import { SCOPES } from './scopes/catalog';
import { view } from './scopes/view.svelte';
import { theme } from '../../ui/theme.svelte';
import { lab } from '../../app/store.svelte';

export interface Key {
  keys: string;
  does: string;
}

const FASTER = 1.25;
/** Share of the time axis. */
const CURSOR_STEP = 0.005;
export const LONG_STEP = 200;

/** Of every screen. */
export const COMMON: readonly Key[] = [
  { keys: 'Esc', does: 'STOP: ramp to rest, then currents to zero; an open sheet closes first' },
  { keys: 't', does: 'Light or dark' },
  { keys: '?', does: 'This sheet' },
];

export const LAB: readonly Key[] = [
  { keys: 'Space', does: 'Play or pause' },
  { keys: 's, S', does: 'Step one tick (0.5 ms), or 100 ms' },
  { keys: 'r', does: 'Reset to 0 s' },
  { keys: '[ ]', does: 'Slower, faster' },
  { keys: 'w, l', does: 'What-if, live' },
  { keys: 'u', does: 'Undo the last change' },
  { keys: 'a', does: 'Apply what-if changes to the session' },
  { keys: '1 to 6', does: 'Show or hide a scope' },
  { keys: '+ −', does: 'Zoom the time axis about the pointer or its middle' },
  { keys: ', .', does: 'Move the time axis' },
  { keys: 'm', does: 'Set cursor 1, then cursor 2, then clear both' },
  { keys: '< >', does: 'Move the cursor that was set last' },
  { keys: 'v', does: 'Readings tell the value, mean, RMS, peak to peak, std' },
  { keys: '0', does: 'Reset zoom and cursors' },
  { keys: 'f', does: 'Value axes follow the data, or hold' },
];

/** While the 3-D view has the focus; all other keys of the Lab act there too. */
export const STAGE: readonly Key[] = [
  {
    keys: 'w a s d q e',
    does: 'Move the camera (Tab into the view first), in place of w, a and s',
  },
  { keys: 'Arrows', does: 'Turn the camera' },
];

/** The plane has to have the focus for all but the first two; trajectory/hand.ts handles them. */
export const TRAJECTORIES: readonly Key[] = [
  { keys: 'Ctrl+Z', does: 'Undo' },
  { keys: 'Ctrl+Y', does: 'Redo; Ctrl+Shift+Z too' },
  { keys: 'Tab', does: 'Next point of the plane, with shift the one before' },
  { keys: 'Arrows', does: 'Move the point by 1 mm, with shift by 0.1 mm; without one the path' },
  { keys: 'Ins', does: 'Add a point after it' },
  { keys: 'Del', does: 'Remove it' },
];

/** Whether the control that has the focus uses a key itself; it may be of another document. */
export function takesKey({ key, target }: KeyboardEvent): boolean {
  if (target === null || !('matches' in target)) return false;
  const control = target as Element;
  if (control.matches('input:not([type=range], [type=checkbox]), select, textarea')) return true;
  // A link does nothing on space.
  return key === ' ' && control.matches('button, summary, input[type=checkbox]');
}

/** Handles a key of the whole page; fields and buttons keep the keys that are theirs. */
export function onKey(event: KeyboardEvent, help: () => void): void {
  if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
  const dialog = document.querySelector<HTMLDialogElement>('dialog[open]');
  if (dialog) {
    if (event.key === 'Escape' && !dialog.matches(':modal')) dialog.close();
    return;
  }
  if (event.key === 'Escape') {
    void lab.stop();
    return;
  }
  if (takesKey(event)) return;
  const action = actions(help)[event.key];
  if (!action) return;
  event.preventDefault();
  action();
}

function actions(help: () => void): Record<string, () => void> {
  const { session } = lab;
  const speed = (factor: number) => {
    void lab.try(() => session.setSpeed(session.speed * factor));
  };
  const scopes = SCOPES.map((scope, i) => [String(i + 1), () => view.toggle(scope.id)] as const);
  return {
    ...Object.fromEntries(scopes),
    ' ': () => void lab.playOrPause(),
    s: () => void lab.step(1),
    S: () => void lab.step(LONG_STEP),
    r: () => void lab.reset(),
    '[': () => speed(1 / FASTER),
    ']': () => speed(FASTER),
    w: () => lab.setMode('whatif'),
    l: () => lab.setMode('live'),
    u: () => void (lab.canUndo && lab.undo()),
    a: () => void (lab.pending > 0 && lab.apply()),
    '0': () => view.reset(),
    '+': () => view.zoomBy(0.5),
    '=': () => view.zoomBy(0.5),
    '-': () => view.zoomBy(2),
    ',': () => view.moveBy(-0.25),
    '.': () => view.moveBy(0.25),
    m: () => view.placeCursor(),
    '<': () => view.nudgeCursor(-CURSOR_STEP),
    '>': () => view.nudgeCursor(CURSOR_STEP),
    v: () => view.nextStatistic(),
    f: () => (view.follow = !view.follow),
    t: () => theme.toggle(),
    '?': help,
  };
}
