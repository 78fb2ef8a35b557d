import { beforeEach, describe, expect, it } from 'vitest';
import { messages } from '../../app/messages.svelte';
import { SavedDocuments } from './saved-documents.svelte';

const entry = (name: string, shipped = false) => ({ name, shipped });

/** Documents, numbers, in a map in place of the server. */
function numbers(change: object = {}) {
  const kept = new Map([
    ['one', 1],
    ['two', 2],
  ]);
  const documents = new SavedDocuments<{ name: string; shipped: boolean }, number>({
    noun: 'number',
    list: async () => [entry('pi', true), ...[...kept.keys()].map((name) => entry(name))],
    drop: async (name) => kept.delete(name),
    put: async (name, value) => kept.set(name, value),
    read: ({ name }) => kept.get(name) ?? NaN,
    ...change,
  });
  return { kept, documents };
}

beforeEach(() => messages.list.forEach(({ id }) => messages.dismiss(id)));

describe('named documents', () => {
  it('are saved, and take the place of another only when confirmed', async () => {
    const { kept, documents } = numbers();
    expect(await documents.save('three', 3)).toBe(true);
    expect(documents.own.map(({ name }) => name)).toEqual(['one', 'two', 'three']);
    expect(await documents.save('one', 4)).toBe(false);
    expect([kept.get('one'), documents.overwrites('one')]).toEqual([1, true]);
    expect(await documents.save('one', 4)).toBe(true);
    expect([kept.get('one'), documents.overwrites('one')]).toEqual([4, false]);
    expect(await documents.save('one', 5, 'one')).toBe(true);
    expect(await documents.save('', 6)).toBe(false);
  });

  it('are renamed, to no name that is in use', async () => {
    const changes: unknown[] = [];
    const { kept, documents } = numbers({ changed: (...names: unknown[]) => changes.push(names) });
    await documents.refresh();
    expect(await documents.rename(entry('one'), ' uno ')).toBe(true);
    expect([...kept]).toEqual([
      ['two', 2],
      ['uno', 1],
    ]);
    expect(changes).toEqual([['uno', 'one']]);
    expect(await documents.rename(entry('uno'), 'two')).toBe(false);
    expect(documents.problem).toBe('There is a number two already.');
    expect([...kept.keys()]).toEqual(['two', 'uno']);
  });

  it('come back by Undo after they were deleted', async () => {
    const { kept, documents } = numbers({ loss: ' Its digits stay.' });
    expect(await documents.remove(entry('two'))).toBe(true);
    expect([...kept.keys()]).toEqual(['one']);
    const [notice] = messages.list;
    expect(notice?.text).toBe('The number two is deleted. Its digits stay.');
    notice?.actions[0]?.run();
    await expect.poll(() => kept.get('two')).toBe(2);
  });

  it('say why something was not done, until something is', async () => {
    const drop = () => Promise.reject(new Error('the disk is full'));
    const { documents } = numbers({ drop });
    expect(await documents.remove(entry('one'))).toBe(false);
    expect(documents.problem).toBe('the disk is full');
    await documents.refresh();
    expect(documents.problem).toBe('');
  });
});
