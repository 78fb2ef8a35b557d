import { expect, it, vi } from 'vitest';
import { onKey } from './keyboard.svelte';

vi.hoisted(() => {
  vi.stubGlobal('location', { href: 'http://127.0.0.1/' });
  vi.stubGlobal('document', { querySelector: () => null });
});

it('a key that acts on the motor acts once, however long it is held', () => {
  const actions = { r: vi.fn(), s: vi.fn() };
  for (const key of ['r', 's']) {
    for (const repeat of [false, true, true]) {
      const preventDefault = vi.fn();
      onKey({ key, repeat, preventDefault, target: null } as unknown as KeyboardEvent, actions);
      expect(preventDefault).toHaveBeenCalled();
    }
  }
  expect(actions.r).toHaveBeenCalledTimes(1);
  expect(actions.s).toHaveBeenCalledTimes(3); // a step each
});

it('enter is that of a link or button that has the focus', () => {
  const actions = { Enter: vi.fn() };
  const press = (tag: string) => {
    const matches = (selector: string) => selector.split(', ').includes(tag);
    onKey({ key: 'Enter', preventDefault: vi.fn(), target: { matches } } as never, actions);
  };
  press('a[href]');
  press('button');
  expect(actions.Enter).not.toHaveBeenCalled();
  press('div');
  expect(actions.Enter).toHaveBeenCalledOnce();
});
