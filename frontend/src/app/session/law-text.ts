/** What is said of a law whose file was saved. */

import type { RunEvent } from '../api/types';

/** A problem with the name of the file in place of its path. */
export function problemText(problem: string): string {
  return problem.replace(/^.*?([^/\\]+\.py)(?=:)/, '$1');
}

/** Whether the file was taken, and why not. */
export function lawText({ law, reason }: Pick<RunEvent, 'law' | 'reason'>): string {
  return reason === ''
    ? `law ${law}: a new version`
    : `law ${law} not taken: ${problemText(reason)}`;
}

/** The same beside a mark on the time axis. */
export function lawMark({ law, reason }: Pick<RunEvent, 'law' | 'reason'>): string {
  return reason === '' ? `law ${law}: a new version` : `law ${law} not taken`;
}
