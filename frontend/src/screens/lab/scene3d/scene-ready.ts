/** Whether the server has a 3-D view to show; asking starts it. */

/** Which process shows it, or why none does, for people. */
export type Standing = { tag: string } | { refusal: string };

export async function ready(path: string, signal: AbortSignal): Promise<Standing> {
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
