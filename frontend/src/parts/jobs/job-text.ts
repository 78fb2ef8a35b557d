/** Duration, time of request and failure of a job, in words. */

import type { JobReport } from '../../app/api/types';

const MINUTE = 60;

/** Formats a time roughly: "under 1 s", "12 s", "3 min". */
export function duration(seconds: number): string {
  if (seconds < 1) return 'under 1 s';
  if (seconds < 2 * MINUTE) return `${Math.round(seconds).toString()} s`;
  return `${Math.round(seconds / MINUTE).toString()} min`;
}

/** Writes a moment in the reader's time: the time of today, else the day too. */
export function moment(iso: string, now = new Date()): string {
  const date = new Date(iso);
  const time = date.toLocaleTimeString('en-GB', {
    hour: '2-digit',
    minute: '2-digit',
    second: '2-digit',
  });
  const today = date.toDateString() === now.toDateString();
  return today ? time : `${date.toLocaleDateString('en-GB')} ${time}`;
}

/** Returns why there is no result: "failed. The motor diverged"; null where nothing went wrong. */
export function trouble({ state, error }: Pick<JobReport, 'state' | 'error'>): string | null {
  if (state === 'failed') return `failed. ${error ?? ''}`;
  return state === 'interrupted' ? `was interrupted: ${error ?? ''}` : null;
}
