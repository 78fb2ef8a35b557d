/** The 3-D view as a part of the page: whether there is one, and without viser's own panel. */

/** Its process, or why there is none, as text. */
export type SceneStatus = { tag: string } | { refusal: string };

/** Asks for the 3-D view, which starts it. */
export async function ready(path: string, signal: AbortSignal): Promise<SceneStatus> {
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
