import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { ApiError, UNREACHABLE } from './api/client';
import { RepeatedStop } from './stop.svelte';

const failure = (status: number) => new ApiError({ title: '', status, detail: '', errors: [] });

/** An attempt that hangs until it is withdrawn, as on a server that is frozen. */
function hangs(signal: AbortSignal): Promise<void> {
  return new Promise((_, reject) =>
    signal.addEventListener('abort', () => reject(new DOMException('', 'AbortError'))),
  );
}

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

describe('STOP', () => {
  it('is sent once where it is answered at once', async () => {
    const send = vi.fn(() => Promise.resolve());
    const stop = new RepeatedStop(send);
    await stop.press();
    expect(send).toHaveBeenCalledTimes(1);
    expect([stop.pending, stop.unsent]).toEqual([false, false]);
  });

  it.each([
    ['there is no network', () => Promise.reject(failure(UNREACHABLE))],
    ['a proxy answers for a server that is down', () => Promise.reject(failure(502))],
    ['the server fails', () => Promise.reject(failure(500))],
    ['the answer is no answer', () => Promise.reject(new SyntaxError('Unexpected end'))],
    ['the request hangs', hangs],
  ])('is repeated while %s, and says so', async (_, fails) => {
    const send = vi.fn<(signal: AbortSignal) => Promise<void>>(fails);
    const stop = new RepeatedStop(send);
    let answered = false;
    const end = stop.press().then(() => (answered = true));
    await vi.advanceTimersByTimeAsync(20_000);
    expect(send.mock.calls.length).toBeGreaterThan(5);
    expect([stop.pending, stop.unsent, answered]).toEqual([true, true, false]);
    send.mockImplementation(() => Promise.resolve());
    await vi.advanceTimersByTimeAsync(3000);
    await end;
    expect([stop.pending, stop.unsent, answered]).toEqual([false, false, true]);
  });

  it('is sent at once when it is pressed again or the network is back', async () => {
    const send = vi.fn<(signal: AbortSignal) => Promise<void>>(hangs);
    const stop = new RepeatedStop(send);
    const end = stop.press();
    await vi.advanceTimersByTimeAsync(1000);
    send.mockImplementation(() => Promise.resolve());
    void stop.press();
    await vi.advanceTimersByTimeAsync(600);
    await end;
    expect(send).toHaveBeenCalledTimes(2);
  });

  it('ends where it is refused', async () => {
    const stop = new RepeatedStop(() => Promise.reject(failure(409)));
    await expect(stop.press()).rejects.toThrow();
    expect([stop.pending, stop.unsent]).toEqual([false, false]);
  });
});
