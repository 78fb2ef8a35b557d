/**
 * Keys pressed while the 3-D view has the focus. It is a document of its own, so the page would not
 * hear of them, not even of Esc, which is STOP.
 */

import { takesKey } from '../../../parts/shell/keyboard.svelte';

/** What viser moves its camera with. */
const CAMERA = ['KeyW', 'KeyA', 'KeyS', 'KeyD', 'KeyQ', 'KeyE'];

/** Passes keys of the 3-D view's window on to the page, but for those that the view itself uses. */
export function passKeys(view: Window, page: Window): void {
  view.addEventListener('keydown', (event) => {
    if (event.key !== 'Escape' && (CAMERA.includes(event.code) || takesKey(event))) return;
    const { key, code, shiftKey, ctrlKey, metaKey, altKey, repeat } = event;
    const same = { key, code, shiftKey, ctrlKey, metaKey, altKey, repeat, cancelable: true };
    if (!page.dispatchEvent(new KeyboardEvent('keydown', same))) event.preventDefault();
  });
}

/** What in the 3-D view is used with keys once it has been clicked. */
const CONTROLS = 'a, button, input, select, textarea, [contenteditable], [tabindex="0"]';

/**
 * Gives the focus back to the page when the mouse has turned the camera, or clicked what takes no
 * keys: the keys that follow are meant for the Lab. Focus that came by Tab, or is on viser's own
 * fields and buttons, stays there.
 */
export function returnFocus(view: Window, frame: HTMLElement): void {
  view.addEventListener('pointerup', ({ target }) => {
    const element = target as Element | null; // of another document: not an instance of this Element
    if (!element || (element.nodeName !== 'CANVAS' && element.closest?.(CONTROLS))) return;
    frame.blur();
    window.focus();
  });
}
