/** Where a popup opens. */

/** Between a popup and its button, and to the edges of the window, px. */
const GAP = 4;
/** Of the top bar, which holds STOP. */
const TOP = 52;

/** Places an open popup below its button, or above it where there is no room, and within the window. */
export function placeAt(button: Element, popup: HTMLElement, align: 'left' | 'right'): void {
  const { left, right, top, bottom } = button.getBoundingClientRect();
  const { width, height } = popup.getBoundingClientRect();
  const below = bottom + 2 * GAP + height <= innerHeight;
  const x = align === 'left' ? left : right - width;
  const y = below ? bottom + GAP : top - GAP - height;
  popup.style.left = `${Math.max(GAP, Math.min(x, innerWidth - width - GAP))}px`;
  popup.style.top = `${Math.max(TOP, y)}px`;
}
