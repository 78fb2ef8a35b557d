import { expect, it, vi } from 'vitest';
import type { Api } from '../api/client';
import type { ReportOf } from '../api/types';
import { JobStore } from './job.svelte';

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
