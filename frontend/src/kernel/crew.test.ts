import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { WorkerEnded, WorkerPort } from './crew';
import type { Request } from './tasks';

const request: Request = { kind: 'curves', variant: 'A', columns: [], bins: {} as never };

/** A port, and the worker behind it, which answers when the test has it do so. */
function portOf() {
  const worker = { postMessage: vi.fn(), terminate: vi.fn() } as unknown as Worker;
  const answer = (id: number) =>
    worker.onmessage?.(new MessageEvent('message', { data: { id, answer: null } }));
  return { worker, answer, port: new WorkerPort(worker) };
}

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

it.each(['onerror', 'onmessageerror'] as const)('nothing waits after %s', async (event) => {
  const { worker, port } = portOf();
  const before = expect(port.post(request)).rejects.toBeInstanceOf(WorkerEnded);
  worker[event]?.(new Event(event) as never);
  await before;
  await expect(port.post(request)).rejects.toBeInstanceOf(WorkerEnded);
  expect(worker.postMessage).toHaveBeenCalledTimes(1);
});

it('a worker that answers nothing has ended', async () => {
  const { worker, port } = portOf();
  const asks = expect(port.post(request)).rejects.toBeInstanceOf(WorkerEnded);
  await vi.advanceTimersByTimeAsync(30_000);
  await asks;
  expect(worker.terminate).toHaveBeenCalled();
});

it('a worker has the time for each request, and none counts while it has no request', async () => {
  const { answer, port } = portOf();
  const asks = [port.post(request), port.post(request)];
  for (const [id, ask] of asks.entries()) {
    await vi.advanceTimersByTimeAsync(20_000);
    answer(id);
    expect(await ask).toBeNull();
  }
  await vi.advanceTimersByTimeAsync(100_000);
  const later = port.post(request);
  answer(2);
  expect(await later).toBeNull();
});
