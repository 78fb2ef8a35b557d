/** The frame of the 3-D view: its process on the server, its document, its keys. */

import { demo, NEEDS_SERVER } from '../../../app/demo/demo-mode';
import { takesKey } from '../../../parts/shell/keyboard.svelte';

/** Its process, or why there is none, as text. */
export type SceneStatus = { tag: string } | { refusal: string };

/** Asks for the 3-D view, which starts it. */
export async function ready(path: string, signal: AbortSignal): Promise<SceneStatus> {
  if (demo) return { refusal: NEEDS_SERVER };
  try {
    let response = await fetch(path, { method: 'HEAD', signal });
    // Only the answer to GET has a body with the reason.
    if (!response.ok) response = await fetch(path, { signal });
    if (response.ok) return { tag: response.headers.get('ETag') ?? '' };
    const problem = (await response.json()) as { detail?: string };
    return { refusal: problem.detail ?? `The server answered ${response.status}.` };
  } catch {
    return { refusal: 'The server does not answer.' };
  }
}

const PANEL = `
  [class*='mantine-Notifications-root'], [data-floating-window] { display: none !important }
`;

/** Hides what is viser's own in its document, and gives it the background of the page. */
export function dress(document: Document, background: string): void {
  const style = document.createElement('style');
  style.textContent =
    PANEL + `body, #root > div, #root div:has(> canvas) { background: ${background} !important }`;
  document.head.append(style);
}

/** Whether this browser can draw in 3-D at all. */
export function drawsIn3d(): boolean {
  return document.createElement('canvas').getContext('webgl2') !== null;
}

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
