import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import type { Api } from '../api/client';
import type { JobState } from '../api/types';
import { jobsNow } from './jobs-now.svelte';

const page = { hidden: false, addEventListener: vi.fn(), removeEventListener: vi.fn() };
vi.stubGlobal('document', page);

const job = (id: string, state: JobState['state'], progress = 0.5) =>
  ({ id, kind: 'tune', state, progress }) as JobState;

let server: JobState[] = [];
const ask = vi.fn(() => Promise.resolve(server));
const cancelJob = vi.fn(() => Promise.resolve(null));
let end: () => void = () => undefined;

beforeEach(() => {
  vi.useFakeTimers();
  ask.mockClear();
  server = [];
});

afterEach(async () => {
  jobsNow.show(false);
  server = [];
  end();
  await vi.advanceTimersByTimeAsync(10_000);
  vi.useRealTimers();
});

async function started(): Promise<void> {
  end = jobsNow.start({ jobsNow: ask, cancelJob } as unknown as Api);
  await vi.advanceTimersByTimeAsync(0);
}

it('asks once, and no more while nothing runs', async () => {
  await started();
  await vi.advanceTimersByTimeAsync(60_000);
  expect(ask).toHaveBeenCalledTimes(1);
});

it('asks once a second while a job runs, and keeps what has ended in this visit', async () => {
  server = [job('mine', 'running'), job('queued', 'queued', 0), job('before', 'done')];
  await started();
  expect(jobsNow.active.map(({ id }) => id)).toEqual(['mine', 'queued']);
  expect(jobsNow.share).toBe(0.25);
  expect(jobsNow.ended).toEqual([]);
  await vi.advanceTimersByTimeAsync(10_000);
  expect(ask).toHaveBeenCalledTimes(11);
  server = [job('mine', 'done', 1), job('queued', 'cancelled', 0), job('before', 'done')];
  await vi.advanceTimersByTimeAsync(60_000);
  expect(ask).toHaveBeenCalledTimes(12);
  expect(jobsNow.active).toEqual([]);
  expect(jobsNow.ended.map(({ id }) => id)).toEqual(['mine', 'queued']);
});

it('notices a job that is noted, and one while the list is open', async () => {
  await started();
  await vi.advanceTimersByTimeAsync(5000);
  server = [job('noted', 'running')];
  jobsNow.note('noted');
  await vi.advanceTimersByTimeAsync(0);
  expect(jobsNow.active.map(({ id }) => id)).toEqual(['noted']);
  server = [];
  await vi.advanceTimersByTimeAsync(5000);
  ask.mockClear();
  jobsNow.show(true);
  await vi.advanceTimersByTimeAsync(3000);
  expect(ask).toHaveBeenCalledTimes(4);
});

it('lists a job that begins and ends between two answers', async () => {
  server = [job('before', 'done')];
  await started();
  jobsNow.show(true);
  await vi.advanceTimersByTimeAsync(3000);
  expect(jobsNow.ended).toEqual([]);
  server = [job('short', 'done', 1), job('before', 'done')];
  await vi.advanceTimersByTimeAsync(2000);
  expect(jobsNow.ended.map(({ id }) => id)).toEqual(['short']);
});

it('does not ask while the page is hidden', async () => {
  server = [job('mine', 'running')];
  await started();
  page.hidden = true;
  ask.mockClear();
  await vi.advanceTimersByTimeAsync(10_000);
  expect(ask).not.toHaveBeenCalled();
  page.hidden = false;
});

it('goes on, more slowly, while the server does not answer', async () => {
  server = [job('mine', 'running')];
  await started();
  ask.mockRejectedValueOnce(new Error('gone'));
  await vi.advanceTimersByTimeAsync(1000);
  expect(jobsNow.reachable).toBe(false);
  await vi.advanceTimersByTimeAsync(4000);
  expect(jobsNow.reachable).toBe(false);
  await vi.advanceTimersByTimeAsync(1000);
  expect(jobsNow.reachable).toBe(true);
});

it('stops a job', async () => {
  server = [job('mine', 'running')];
  await started();
  await jobsNow.stop(job('mine', 'running'));
  expect(cancelJob).toHaveBeenCalledWith('mine');
});
