import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { messages } from './messages.svelte';

const texts = () => messages.list.map(({ text }) => text);

beforeEach(() => {
  vi.useFakeTimers();
});

afterEach(() => {
  messages.hold(false);
  for (const { id } of messages.list) messages.dismiss(id);
  vi.useRealTimers();
});

it('lets notices go by themselves and keeps errors until they are dismissed', () => {
  messages.error('Not computed.');
  messages.info('Saved.');
  expect(texts()).toEqual(['Not computed.', 'Saved.']);
  vi.advanceTimersByTime(60_000);
  expect(texts()).toEqual(['Not computed.']);
  messages.dismiss(messages.list[0]?.id ?? 0);
  expect(texts()).toEqual([]);
});

it('keeps a notice while the pointer or the focus is on it', () => {
  messages.info('Saved.');
  messages.hold(true);
  vi.advanceTimersByTime(60_000);
  expect(texts()).toEqual(['Saved.']);
  messages.hold(false);
  vi.advanceTimersByTime(60_000);
  expect(texts()).toEqual([]);
});

it('says the same once, the last time it was said', () => {
  messages.info('Saved.');
  messages.error('Not computed.');
  messages.info('Saved.');
  expect(texts()).toEqual(['Not computed.', 'Saved.']);
});

it('goes when it was acted on', () => {
  const run = vi.fn();
  const undo = { name: 'Undo', run };
  messages.info('The path was replaced.', [undo]);
  messages.act(messages.list[0]?.id ?? 0, undo);
  expect(run).toHaveBeenCalledOnce();
  expect(texts()).toEqual([]);
});
