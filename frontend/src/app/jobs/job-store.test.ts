import { beforeEach, describe, expect, it, vi } from 'vitest';
import { ApiError, type Api } from '../api/client';
import type { ReportOf } from '../api/types';
import { JobStore } from './job-store.svelte';
import { openJob } from './open-job';

/** A browser's storage, which outlives a reload. */
const storage = new Map<string, string>();
vi.stubGlobal('localStorage', {
  getItem: (key: string) => storage.get(key) ?? null,
  setItem: (key: string, value: string) => storage.set(key, value),
});
beforeEach(() => storage.clear());

const done = { id: 'a', kind: 'tune', state: 'done' } as ReportOf<'tune'>;

it('asks for one job where its button is pressed twice, and for another after that', async () => {
  const start = vi.fn(() => Promise.resolve(done));
  const job = new JobStore({ start } as unknown as Api, 'tune');
  await Promise.all([job.start('/tune', {}), job.start('/tune', {})]);
  expect(start).toHaveBeenCalledTimes(1);
  await job.start('/tune', {});
  expect(start).toHaveBeenCalledTimes(2);
});

it('keeps to the job that was asked for while an earlier one was looked for', async () => {
  const earlier = { ...done, id: 'b' };
  let answer: (report: ReportOf<'tune'>) => void = () => undefined;
  const look = vi.fn(() => new Promise((resolve) => (answer = resolve)));
  const api = {
    jobs: () => Promise.resolve([earlier]),
    job: look,
    start: () => Promise.resolve(done),
  };
  const job = new JobStore(api as unknown as Api, 'tune');
  storage.set('motionlab.jobs.tune', '["b"]');
  const resumed = job.resume();
  await vi.waitFor(() => expect(look).toHaveBeenCalled());
  await job.start('/tune', {});
  answer(earlier);
  await resumed;
  expect(job.report).toEqual(done);
});

it('asks again after a refusal', async () => {
  const start = vi.fn().mockRejectedValueOnce(new Error('no')).mockResolvedValue(done);
  const job = new JobStore({ start } as unknown as Api, 'tune');
  await expect(job.start('/tune', {})).rejects.toThrow('no');
  await job.start('/tune', {});
  expect(job.report).toEqual(done);
});

it.each([
  ['a body that breaks off', new SyntaxError('Unexpected end of JSON input')],
  ['a server out of reach', new ApiError({ title: '', status: 0, detail: '', errors: [] })],
  ['a server that is overloaded', new ApiError({ title: '', status: 503, detail: '', errors: [] })],
])('goes on asking after %s', async (_, failure) => {
  vi.useFakeTimers();
  const running = { ...done, state: 'running' } as ReportOf<'tune'>;
  const look = vi.fn().mockRejectedValueOnce(failure).mockResolvedValue(done);
  const api = {
    jobs: () => Promise.resolve([done]),
    job: look,
    start: () => Promise.resolve(running),
  };
  const job = new JobStore(api as unknown as Api, 'tune');
  await job.start('/tune', {});
  await vi.advanceTimersByTimeAsync(300);
  expect(job.reachable).toBe(false);
  await vi.advanceTimersByTimeAsync(3000);
  expect([job.report?.state, job.reachable]).toEqual(['done', true]);
  vi.useRealTimers();
});

describe('found again', () => {
  const record = (id: string, state: string, request = {}) =>
    ({ id, kind: 'tune', state, request }) as ReportOf<'tune'>;

  /** A page that has just been loaded, with what the server has of others and of this browser. */
  function opened(records: ReportOf<'tune'>[]) {
    const restore = vi.fn();
    const api = {
      jobs: () => Promise.resolve(records),
      job: (id: string) => Promise.resolve(records.find((one) => one.id === id)),
      start: () => Promise.resolve(records[0]),
    };
    return { job: new JobStore(api as unknown as Api, 'tune', restore), restore };
  }

  it('are jobs that this browser has asked for, and no others', async () => {
    const [mine, theirs] = [record('mine', 'done'), record('theirs', 'done')];
    await opened([mine]).job.start('/tune', {});
    const { job } = opened([record('newer', 'running'), theirs, mine]);
    await job.resume();
    expect(job.report?.id).toBe('mine');
    expect(job.records.map((one) => job.isOwn(one))).toEqual([false, false, true]);
  });

  it('is nothing in a fresh browser, where the jobs of others are listed', async () => {
    const { job } = opened([record('running', 'running'), record('theirs', 'done')]);
    await job.resume();
    expect(job.report).toBeNull();
    expect(job.records.length).toBe(2);
  });

  it('is one that runs before one that is done', async () => {
    const [runs, ended] = [record('runs', 'running'), record('ended', 'done')];
    await opened([runs]).job.start('/tune', {});
    await opened([ended]).job.start('/tune', {});
    const { job } = opened([ended, runs]);
    await job.resume();
    expect(job.report?.id).toBe('runs');
  });

  it('is one that the end of the server interrupted', async () => {
    const interrupted = record('mine', 'interrupted');
    await opened([interrupted]).job.start('/tune', {});
    const { job } = opened([interrupted, record('failed', 'failed')]);
    await job.resume();
    expect(job.report?.state).toBe('interrupted');
    expect(job.records.map(({ id }) => id)).toEqual(['mine']);
  });

  it('is one of others that was chosen, with its request in the form', async () => {
    const theirs = record('theirs', 'done', { starts: 2 });
    const { job, restore } = opened([theirs]);
    await job.open('theirs');
    expect(restore).toHaveBeenCalledWith({ starts: 2 });
    expect(job.isOwn(theirs)).toBe(false);
    const again = opened([theirs]);
    await again.job.resume();
    expect(again.job.report?.id).toBe('theirs');
    expect(again.restore).not.toHaveBeenCalled();
  });

  const shipped = { ...record('shipped', 'done'), shipped: true };

  it('is the newest of the server where the program ships a result, else that one', async () => {
    const [newer, theirs] = [record('newer', 'running'), record('theirs', 'done')];
    const { job } = opened([newer, theirs, record('older', 'done'), shipped]);
    await job.resume();
    expect(job.report?.id).toBe('theirs');
    const fresh = opened([shipped]);
    await fresh.job.resume();
    expect(fresh.job.report?.id).toBe('shipped');
    expect(fresh.restore).not.toHaveBeenCalled();
    storage.clear();
    await opened([shipped]).job.resume();
    const later = opened([theirs, shipped]);
    await later.job.resume();
    expect(later.job.report?.id).toBe('theirs');
  });

  it('is one of its own before the shipped one', async () => {
    const mine = record('mine', 'done');
    await opened([mine]).job.start('/tune', {});
    const { job } = opened([record('theirs', 'done'), mine, shipped]);
    await job.resume();
    expect(job.report?.id).toBe('mine');
  });

  it('is one that is opened from another screen', async () => {
    const mine = record('mine', 'done');
    const theirs = record('theirs', 'running');
    await opened([mine]).job.start('/tune', {});
    const { job } = opened([theirs, mine]);
    await job.resume();
    await openJob('tune', 'theirs');
    expect(job.report?.id).toBe('theirs');
    // Its screen is not there yet.
    await openJob('sweep', 'swept');
    const api = { job: (id: string) => Promise.resolve(record(id, 'done')), jobs: () => [] };
    const other = new JobStore(api as unknown as Api, 'sweep');
    await other.resume();
    expect(other.report?.id).toBe('swept');
  });

  it('says when another version of the model has computed it', async () => {
    const { job } = opened([{ ...shipped, other_model: true } as ReportOf<'tune'>]);
    await job.resume();
    expect(job.otherModel).toBe(true);
  });
});
