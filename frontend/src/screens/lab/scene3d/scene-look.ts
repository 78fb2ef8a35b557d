/** The 3-D view as a part of the page: without viser's own panel, notes and colours. */

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
