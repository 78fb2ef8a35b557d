/** What takes the focus by Tab, and where the focus goes when what has it goes away. */

import { loop } from './animation-loop';

const STOPS =
  'a[href], button, input, select, textarea, summary, iframe, [tabindex]:not([tabindex="-1"])';
/** What work goes on in after one of its controls has gone. */
const HOMES = 'main, section, figure, form, dialog, [popover], [role=dialog]';

/** Gives the focus to a part of the page that Tab leaves out. */
export function focusPart(part: HTMLElement): void {
  if (part.tabIndex < 0 && !part.hasAttribute('tabindex')) part.tabIndex = -1;
  part.focus();
}

function shown(element: Element): boolean {
  return element.isConnected && element.checkVisibility({ visibilityProperty: true });
}

/** Whether it is shown, but does not take the focus now. */
function off(element: Element): boolean {
  return element.matches(':disabled') || element.closest('[inert]') !== null;
}

/**
 * Keeps the focus of those who go by keys where they work. What has the focus may be removed, as a
 * row by its own button: then a neighbour gets it. It may be disabled while its work is done: then it
 * gets the focus back. Returns what ends it.
 */
export function keepFocus(): () => void {
  const stop = new AbortController();
  /** What has the focus, and what it lies in, from the inside out; empty for those who point. */
  let path: HTMLElement[] = [];
  /** What takes its place: what follows, else what is before it. */
  let neighbours: HTMLElement[] = [];
  let waiting = false;
  let keys = false;

  function note(): void {
    const focused = document.activeElement;
    if (!keys || !(focused instanceof HTMLElement) || focused === document.body) return;
    [path, waiting] = [[], false];
    for (let each: HTMLElement | null = focused; each; each = each.parentElement) path.push(each);
    const all = [...document.querySelectorAll<HTMLElement>(STOPS)];
    const place = all.indexOf(focused);
    neighbours = [...all.slice(place + 1), ...all.slice(0, Math.max(0, place)).reverse()];
  }

  function mend(): void {
    const [last] = path;
    if (!last || document.activeElement !== document.body) return;
    if (shown(last)) {
      if (off(last)) waiting = true;
      else if (waiting) last.focus();
      else path = []; // it was left
      return;
    }
    const home =
      path.find((each) => shown(each) && each.matches(HOMES)) ??
      document.querySelector<HTMLElement>('main');
    if (!home) return; // the next screen is being loaded
    const next = home.matches('main')
      ? undefined
      : neighbours.find((each) => home.contains(each) && shown(each) && !off(each));
    if (next) next.focus();
    else focusPart(home);
  }

  const point = () => {
    [keys, path] = [false, []];
  };
  const press = () => {
    keys = true;
    note();
  };
  const options = { capture: true, signal: stop.signal };
  document.addEventListener('pointerdown', point, options);
  document.addEventListener('keydown', press, options);
  document.addEventListener('focusin', note, options);
  const remove = loop.add(mend);
  return () => {
    remove();
    stop.abort();
  };
}

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
