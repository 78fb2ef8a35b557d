/** The panels of the page, in their order. */

import { focusPart } from '../../ui/focus';

const PANELS = 'main section[aria-label], main > [aria-label], dialog[open], .message, .tour';

/** Returns the panels that are shown, in their order; none within another. */
export function panels(root: ParentNode): HTMLElement[] {
  return [...root.querySelectorAll<HTMLElement>(PANELS)].filter(
    (panel) =>
      !panel.parentElement?.closest(PANELS) && !panel.closest('[inert]') && panel.checkVisibility(),
  );
}

/** Gives the focus to the next panel, or to the one before. */
export function nextPanel(way: 1 | -1): void {
  const all = panels(document);
  const at = document.activeElement;
  const inside = all.findIndex((panel) => panel.contains(at));
  const from = inside < 0 && way < 0 ? 0 : inside;
  const next = all.at((from + way) % all.length);
  if (next) focusPart(next);
}
