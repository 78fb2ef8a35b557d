/** Jobs that are shown from elsewhere: by the store of their kind, now or once it is there. */

import type { JobKind } from '../api/types';

interface Opener {
  open: (id: string) => Promise<void>;
}

const openers = new Map<JobKind, Opener>();
const pending = new Map<JobKind, string>();

/** Has the screen of a kind of job show one of them, now or when it is loaded. */
export async function openJob(kind: JobKind, id: string): Promise<void> {
  const opener = openers.get(kind);
  if (opener) await opener.open(id);
  else pending.set(kind, id);
}

/** Notes the store that shows a kind of job, and opens the one that waits for it. */
export async function opensJobs(kind: JobKind, opener: Opener): Promise<void> {
  openers.set(kind, opener);
  const id = pending.get(kind);
  pending.delete(kind);
  if (id !== undefined) await opener.open(id);
}
