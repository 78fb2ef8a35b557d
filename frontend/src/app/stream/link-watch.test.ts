import { beforeEach, describe, expect, it, vi } from 'vitest';
import { LinkWatch } from './link-watch.svelte';

let now = 0;
const watched = {
  heardAt: null as number | null,
  moving: true,
  ask: vi.fn<() => Promise<unknown>>(),
  reconnect: vi.fn(),
};

function watch(): LinkWatch {
  return new LinkWatch(watched, () => now);
}

/** Looks five times a second for some seconds. */
async function pass(link: LinkWatch, seconds: number): Promise<void> {
  for (const end = now + 1000 * seconds; now < end; now += 200) {
    link.look();
    await Promise.resolve();
    await Promise.resolve();
  }
  link.look();
}

beforeEach(() => {
  now = 10_000;
  Object.assign(watched, { heardAt: null, moving: true, ask: vi.fn(), reconnect: vi.fn() });
  watched.ask.mockRejectedValue(new Error('no answer'));
});

describe('while it plays', () => {
  it('data that are missing for a second are said, with their age', async () => {
    watched.heardAt = now;
    const link = watch();
    await pass(link, 0.8);
    expect(link.text).toBe('');
    await pass(link, 0.4);
    expect(link.text).toBe('no data since 1 s');
    await pass(link, 3);
    expect(link.text).toBe('no data since 4 s');
    watched.heardAt = now;
    link.look();
    expect(link.text).toBe('');
  });

  it('a pause before is no silence', async () => {
    watched.heardAt = now - 60_000;
    const link = watch();
    await pass(link, 0.8);
    expect(link.text).toBe('');
  });

  it('an answer to a question does not hide that data are missing', async () => {
    watched.ask.mockResolvedValue({});
    watched.heardAt = now;
    const link = watch();
    await pass(link, 4);
    expect(link.text).toBe('no data since 4 s');
  });

  it('a stream that stays silent though the server answers is opened anew', async () => {
    watched.heardAt = now;
    const link = watch();
    await pass(link, 8);
    expect(watched.reconnect).not.toHaveBeenCalled();
    watched.ask.mockResolvedValue({});
    await pass(link, 1);
    expect(watched.reconnect).toHaveBeenCalledTimes(1);
  });
});

describe('at rest', () => {
  beforeEach(() => {
    watched.moving = false;
    watched.heardAt = now;
  });

  it('the server is asked, and is well while it answers', async () => {
    watched.ask.mockResolvedValue({});
    const link = watch();
    await pass(link, 30);
    expect(link.text).toBe('');
    expect(watched.ask.mock.calls.length).toBeLessThan(20);
  });

  it('a server that no longer answers is said', async () => {
    const link = watch();
    await pass(link, 5);
    expect(link.text).toBe('no answer since 5 s');
  });
});

it('says nothing before the stream has brought anything', async () => {
  const link = watch();
  await pass(link, 5);
  expect(link.text).toBe('');
});
