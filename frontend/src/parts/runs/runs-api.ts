/** Calls about runs, apart from the client: it is loaded at once, they are not. */

import { noteRecorded } from '../../plot/source';
import type { RequestOf } from '../../app/api/operations';
import type { SpectrumSettings } from '../spectrum/spectrum-view';
import { app } from '../../app/store.svelte';

/** What can be changed of a run. */
export interface RunChange {
  name?: string;
  note?: string;
  tags?: string[];
  pinned?: boolean;
}

export interface ListRequest {
  q: string;
  sort: string;
  limit: number;
  cursor?: string;
}

const { api } = app;
const of = (run_id: string) => ({ path: { run_id } });

export const listRuns = (query: ListRequest) => api.json('get', '/runs', { query });
export const runHistogram = (q: string, metric: string) =>
  api.json('get', '/runs/histogram', { query: { q, metric } });
export const runStorage = () => api.json('get', '/runs/storage', {});
export async function getRun(id: string) {
  const run = await api.json('get', '/runs/{run_id}', of(id));
  noteRecorded(run.columns.map(({ name = '' }) => name));
  return run;
}
export const changeRun = (id: string, body: RunChange) =>
  api.json('patch', '/runs/{run_id}', { ...of(id), body });
export const deleteRun = (id: string) => api.json('delete', '/runs/{run_id}', of(id));
export const restoreRun = (id: string) => api.json('post', '/runs/{run_id}/restore', of(id));
export const compareRuns = (body: RequestOf<'/runs/compare'>) =>
  api.json('post', '/runs/compare', { body });
/** One channel of both over instants [from, to). */
export const compareWindow = (body: RequestOf<'/runs/compare/window'>) =>
  api.bytes('/runs/compare/window', { body }, 'post');
/** At once, or the report of a job where it takes long. */
export const replayRun = (id: string) => api.json('post', '/runs/{run_id}/replay', of(id));
/** All runs of a search, as a job. */
export const replayRuns = (q: string) => api.json('post', '/runs/replay', { body: { q } });
export interface ImportQuery {
  preview?: boolean;
  name?: string;
  rate?: number;
  resample?: number;
  delimiter?: '' | 'comma' | 'semicolon' | 'tab';
  decimal?: '' | 'point' | 'comma';
  /** Of two files in one body. */
  first_bytes?: number;
  align?: string;
  offset?: number;
  map?: string[];
}
/** How a file of a measurement is read; without `preview` it becomes a run. */
export const importRun = (body: Blob, query: ImportQuery) =>
  api.json('post', '/runs/import', { body, query });
/** Minima and maxima of columns over samples [from, to). */
export const runWindow = (
  id: string,
  query: { columns: string; from: number; to: number; points: number },
) => api.bytes('/runs/{run_id}/window', { ...of(id), query });
/** The following error at every reversal of its axes. */
export const runGlitches = (id: string) => api.json('get', '/runs/{run_id}/glitches', of(id));
/** Spectra of columns over samples [from, to). */
export const runSpectrum = (
  id: string,
  query: { columns: string; from: number; to: number } & SpectrumSettings,
) => api.json('get', '/runs/{run_id}/spectrum', { ...of(id), query });
