/** Everything that a person can reach by typing its name. */

import type { KeyTable } from '../keys';

export interface Command {
  name: string;
  /** Where it is, or what it is: a screen, a panel, a channel. */
  place: string;
  /** The key that does the same; empty for none. */
  key: string;
  run(): void;
}

const CONTROLS = 'button, input, select, textarea, summary, a[href]';

/** Returns the controls of the present screen and of the top bar, by their names and panels. */
export function controls(root: ParentNode): Command[] {
  return [...root.querySelectorAll<HTMLElement>(CONTROLS)].flatMap((control) => {
    const name = nameOf(control);
    const off = control.matches(':disabled, [aria-hidden="true"], [type="file"]');
    if (off || name === '' || control.closest('dialog, [popover]')) return [];
    if (!control.checkVisibility()) return [];
    return [{ name, place: placeOf(control), key: '', run: () => reach(control) }];
  });
}

function nameOf(control: HTMLElement): string {
  const label = (control as HTMLInputElement).labels?.[0];
  const named = control.ariaLabel ?? label?.textContent ?? control.textContent;
  const text = control.matches('select') ? (control.ariaLabel ?? label?.textContent ?? '') : named;
  const tidy = text.replace(/\s+/g, ' ').trim();
  // A sign alone says nothing to somebody who types.
  return /\p{L}/u.test(tidy) ? tidy : (control.title.split(/[:;(]/)[0] ?? '').trim();
}

function placeOf(control: HTMLElement): string {
  const panel = control.parentElement?.closest('section[aria-label], [role=region][aria-label]');
  return panel?.ariaLabel ?? '';
}

/** Presses a button; goes to a field. */
function reach(control: HTMLElement): void {
  control.scrollIntoView({ block: 'nearest' });
  control.focus();
  if (control.matches('button, summary, a')) control.click();
  else if (control instanceof HTMLInputElement && control.type === 'text') control.select();
}

/** Returns what the keys of a screen do, those that have one key each. */
export function ofKeys(table: KeyTable, actions: Record<string, () => void>): Command[] {
  return table.keys.flatMap(({ keys, does }) => {
    const run = actions[keys === 'Space' ? ' ' : keys];
    return run ? [{ name: does, place: table.title, key: keys, run }] : [];
  });
}

/** Returns those in which every word that was typed occurs; those that begin with the first word first. */
export function matching(commands: readonly Command[], typed: string): Command[] {
  const words = typed.toLowerCase().split(/\s+/).filter(Boolean);
  const [first = ''] = words;
  const found = commands.filter(({ name, place }) => {
    const text = `${name} ${place}`.toLowerCase();
    return words.every((word) => text.includes(word));
  });
  const rank = ({ name }: Command) => (name.toLowerCase().startsWith(first) ? 0 : 1);
  return found.sort((a, b) => rank(a) - rank(b));
}
