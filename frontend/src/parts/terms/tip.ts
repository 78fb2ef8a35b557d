/** One explanation at a time, beside what it explains: on hover, and on focus by keyboard. */

import type { Attachment } from 'svelte/attachments';
import { placeAt } from '../../ui/popup';
import type { Entry, TermName } from './glossary';

let tip: HTMLElement | null = null;
let owner: Element | null = null;

/**
 * Explains a term while the pointer is over an element, or the focus is in it.
 *
 * @param name null: nothing to explain
 */
export function explains(name: TermName | null): Attachment<HTMLElement> {
  return (element) => {
    if (!name) return undefined;
    const on = new AbortController();
    const listen = (type: string, run: (event: Event) => void) => {
      element.addEventListener(type, run, { signal: on.signal });
    };
    /** The entries are loaded with the first that is shown, if its term has pointer or focus by then. */
    const open = async (still: () => boolean) => {
      const { GLOSSARY } = await import('./glossary');
      return !on.signal.aborted && still() && show(element, GLOSSARY[name]);
    };
    listen('pointerenter', () => void open(() => element.matches(':hover')));
    listen('focusin', async ({ target }) => {
      const focused = target as HTMLElement;
      // A click puts the focus there too: what was clicked needs no explanation.
      if (await open(() => focused.matches(':focus-visible')))
        focused.setAttribute('aria-describedby', 'term-tip');
    });
    listen('pointerleave', () => {
      if (!element.contains(document.activeElement)) hide(element);
    });
    listen('focusout', () => hide(element));
    listen('pointerdown', () => hide(element));
    listen('keydown', (event) => {
      if ((event as KeyboardEvent).key === 'Escape') hide(element);
    });
    return () => {
      on.abort();
      hide(element);
    };
  };
}

function show(element: HTMLElement, { name, text }: Entry): true {
  if (owner && owner !== element) hide(owner);
  owner = element;
  tip ??= made();
  const head = document.createElement('b');
  head.append(...lettered(name));
  tip.replaceChildren(head, ' ', ...lettered(text));
  if (!tip.matches(':popover-open')) tip.showPopover();
  placeAt(element, tip, 'left');
  return true;
}

function hide(element: Element): void {
  if (owner !== element) return;
  owner = null;
  if (tip?.matches(':popover-open')) tip.hidePopover();
  for (const described of [element, ...element.querySelectorAll('[aria-describedby="term-tip"]')])
    if (described.getAttribute('aria-describedby') === 'term-tip')
      described.removeAttribute('aria-describedby');
}

function made(): HTMLElement {
  const element = document.createElement('div');
  element.id = 'term-tip';
  element.className = 'term-tip';
  element.role = 'tooltip';
  element.popover = 'manual';
  document.body.append(element);
  return element;
}

/** A text with its subscripts: `k_p` becomes k with a low p. */
function lettered(text: string): (string | HTMLElement)[] {
  return text.split(/_(\w+)/).map((part, i) => {
    if (i % 2 === 0) return part;
    const low = document.createElement('sub');
    low.textContent = part;
    return low;
  });
}
