/** Keys of the Lab screen; the help sheet lists the same table. */

import { SCOPES } from '../scope/catalog';
import { view } from '../scope/view.svelte';
import { theme } from '../ui/theme.svelte';
import { lab } from './lab.svelte';

export interface Key {
  keys: string;
  does: string;
}

const FASTER = 1.25;
const SPEED = { least: 0.1, most: 10 };
export const LONG_STEP = 200;

export const KEYS: readonly Key[] = [
  { keys: 'Esc', does: 'STOP: ramp to rest, then currents to zero' },
  { keys: 'Space', does: 'Play or pause' },
  { keys: 's, S', does: 'Step one tick (0.5 ms), or 100 ms' },
  { keys: 'r', does: 'Reset to 0 s' },
  { keys: '[ ]', does: 'Slower, faster' },
  { keys: 'w, l', does: 'What-if, live' },
  { keys: 'u', does: 'Undo the last change' },
  { keys: 'a', does: 'Apply what-if changes to the session' },
  { keys: '1 to 6', does: 'Show or hide a scope' },
  { keys: '+ −', does: 'Zoom the time axis, about the pointer or the middle' },
  { keys: ', .', does: 'Move the time axis' },
  { keys: 'm', does: 'Set or clear the mark' },
  { keys: '0', does: 'Reset zoom and mark' },
  { keys: 'f', does: 'Value axes follow the data, or hold' },
  { keys: 't', does: 'Light or dark' },
  { keys: '?', does: 'This sheet' },
];

/** Handles a key of the whole page; fields and buttons keep the keys that are theirs. */
export function onKey(event: KeyboardEvent, help: () => void): void {
  if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
  const target = event.target instanceof Element ? event.target : null;
  if (document.querySelector('dialog[open]')) return;
  if (event.key === 'Escape') {
    void lab.stop();
    return;
  }
  if (target?.matches('input:not([type=range], [type=checkbox]), select, textarea')) return;
  if (event.key === ' ' && target?.matches('button, a, summary, input[type=checkbox]')) return;
  const action = actions(help)[event.key];
  if (!action) return;
  event.preventDefault();
  action();
}

function actions(help: () => void): Record<string, () => void> {
  const { session } = lab;
  const speed = (factor: number) => {
    const next = Number((session.speed * factor).toPrecision(2));
    void lab.try(() => session.setSpeed(Math.min(SPEED.most, Math.max(SPEED.least, next))));
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
    m: () => view.toggleMark(),
    f: () => (view.follow = !view.follow),
    t: () => theme.toggle(),
    '?': help,
  };
}
