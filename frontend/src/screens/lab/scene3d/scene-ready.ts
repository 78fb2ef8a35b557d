/** Whether the server has a 3-D view to show; the request starts it. */

/** Its process, or why there is none, as text. */
export type SceneStatus = { tag: string } | { refusal: string };

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
