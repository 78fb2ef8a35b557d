/** Moves the focus among the buttons of a group by the arrow keys, to the nearest in that direction. */

const WAYS: Record<string, readonly [number, number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};
/** What lies aside counts so much more than what lies ahead. */
const ASIDE = 4;

/** For `onkeydown` of the group; Home and End go to its first and last button. */
export function arrowKeys(event: KeyboardEvent & { currentTarget: HTMLElement }): void {
  if (event.ctrlKey || event.metaKey || event.altKey || event.shiftKey) return;
  const buttons = [...event.currentTarget.querySelectorAll<HTMLButtonElement>('button:enabled')];
  const from = buttons.find((button) => button === document.activeElement);
  const way = WAYS[event.key];
  const end = { Home: buttons[0], End: buttons.at(-1) }[event.key];
  if (!from || !(way || end)) return;
  event.preventDefault();
  event.stopPropagation();
  if (way) towards(from, buttons, way)?.focus();
  else end?.focus();
}

function towards(
  from: HTMLElement,
  buttons: readonly HTMLElement[],
  [x, y]: readonly [number, number],
): HTMLElement | undefined {
  const [x0, y0] = middle(from);
  const candidates = buttons.flatMap((button) => {
    const [dx, dy] = [middle(button)[0] - x0, middle(button)[1] - y0];
    const ahead = dx * x + dy * y;
    const aside = Math.abs(dx * y) + Math.abs(dy * x);
    return ahead > 1 ? [{ button, far: ahead + ASIDE * aside }] : [];
  });
  return candidates.sort((a, b) => a.far - b.far)[0]?.button;
}

function middle(element: HTMLElement): readonly [number, number] {
  const { left, right, top, bottom } = element.getBoundingClientRect();
  return [(left + right) / 2, (top + bottom) / 2];
}
