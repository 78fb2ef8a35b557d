/** Duration, time of request and failure of a job, in words. */

import type { JobKind, JobReport, JobState } from '../../app/api/types';
import type { Screen } from '../../app/screen.svelte';

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

/** Writes a day in the reader's time. */
export function day(iso: string): string {
  return new Date(iso).toLocaleDateString('en-GB', {
    day: 'numeric',
    month: 'long',
    year: 'numeric',
  });
}

/** Where a result came from: of a shipped one its version and day, else when it was asked for. */
export function originOf({
  shipped,
  version,
  created,
  elapsed,
}: Pick<JobReport, 'shipped' | 'version' | 'created' | 'elapsed'>): string {
  return shipped
    ? `Shipped with ${version ?? ''}, computed on ${day(created)}`
    : `${moment(created)}, took ${duration(elapsed)}`;
}

const WAITS: Readonly<Record<NonNullable<JobState['waits_for']>, string>> = {
  server: 'waits for the server to start',
  jobs: 'waits for other jobs to end',
  kernels: 'waits for code that is compiled, once on this machine',
  memory: 'waits for memory that runs and sessions hold',
};

/** Says how far a job is that waits or runs. */
export function progressOf({
  state,
  progress,
  remaining,
  waits_for,
}: Pick<JobState, 'state' | 'progress' | 'remaining' | 'waits_for'>): string {
  if (state === 'queued') return WAITS[waits_for ?? 'jobs'];
  const percent = `${Math.floor(100 * progress).toString()}\u00a0%`;
  if (remaining === null) return percent;
  return `${percent}, ${remaining < 1 ? '' : 'about '}${duration(remaining)} left`;
}

/** What a kind of job is called, and where its result is shown. */
interface Place {
  name: string;
  screen: Screen;
  /** What the address of the screen says besides. */
  parameters?: Readonly<Record<string, string>>;
}

const PLACES: Readonly<Record<JobKind, Place>> = {
  identify: { name: 'Identification', screen: 'identify' },
  'safe-tune': { name: 'Tuning on the machine', screen: 'tune' },
  'friction-models': { name: 'Friction models', screen: 'identify' },
  tune: { name: 'Search for gains', screen: 'tune' },
  landscape: { name: 'Map of the cost', screen: 'tune' },
  response: { name: 'Measured loop', screen: 'tune' },
  shape: { name: 'Shaped loop', screen: 'tune' },
  'frequency-sweep': { name: 'Swept loop', screen: 'tune' },
  learn: { name: 'Learning', screen: 'lab' },
  minute: { name: 'The same minute', screen: 'runs' },
  'monte-carlo': { name: 'Monte Carlo', screen: 'lab' },
  sweep: { name: 'Sweep', screen: 'sweep' },
  sensitivity: { name: 'Sensitivity', screen: 'sweep' },
  map: { name: 'Force map', screen: 'motor', parameters: { tab: 'maps' } },
  reproduce: { name: 'Reproduction', screen: 'paper' },
  simulate: { name: 'Simulation', screen: 'runs' },
  replay: { name: 'Check of a run', screen: 'runs' },
  replays: { name: 'Check of runs', screen: 'runs' },
};

/** Returns the place of a kind of job; of a study of one's own it has no screen: null. */
export function placeOf(kind: string): { name: string } & Partial<Place> {
  const known: Readonly<Partial<Record<string, Place>>> = PLACES;
  return known[kind] ?? { name: kind };
}

/** Returns why there is no result: "failed. The motor diverged"; null where nothing went wrong. */
export function trouble({ state, error }: Pick<JobReport, 'state' | 'error'>): string | null {
  if (state === 'failed') return `failed. ${error ?? ''}`;
  return state === 'interrupted' ? `was interrupted: ${error ?? ''}` : null;
}
