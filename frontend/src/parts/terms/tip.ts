/** One explanation at a time, beside what it explains: on hover, and on focus by keyboard. */

import type { Attachment } from 'svelte/attachments';
import type { Entry, TermName } from './glossary';

/** Between term and its explanation, and to the edges of the window, px. */
const GAP = 4;

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
    let entry: Entry | null = null;
    void import('./glossary').then(({ GLOSSARY }) => (entry = GLOSSARY[name]));
    const on = new AbortController();
    const listen = (type: string, run: (event: Event) => void) => {
      element.addEventListener(type, run, { signal: on.signal });
    };
    const open = () => entry && show(element, entry);
    listen('pointerenter', open);
    listen('focusin', (event) => {
      const focused = event.target as HTMLElement;
      // A click puts the focus there too: what was clicked needs no explanation.
      if (focused.matches(':focus-visible') && open())
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

/** Below the element, or above it where there is no room, and within the window. */
function show(element: HTMLElement, { name, text }: Entry): true {
  if (owner && owner !== element) hide(owner);
  owner = element;
  tip ??= made();
  const head = document.createElement('b');
  head.append(...lettered(name));
  tip.replaceChildren(head, ' ', ...lettered(text));
  if (!tip.matches(':popover-open')) tip.showPopover();
  const at = element.getBoundingClientRect();
  const { width, height } = tip.getBoundingClientRect();
  const below = at.bottom + GAP;
  const top = below + height < innerHeight ? below : at.top - height - GAP;
  tip.style.left = `${Math.max(GAP, Math.min(at.left, innerWidth - width - GAP))}px`;
  tip.style.top = `${Math.max(GAP, top)}px`;
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
