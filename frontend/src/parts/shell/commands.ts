/** Everything that a person can reach by typing its name. */

import { focusPart } from '../../ui/focus';
import type { KeyTable } from './keyboard.svelte';
import { panels } from './panels';

export interface Command {
  name: string;
  /** Where it is, or what it is: a screen, a panel, a channel. */
  place: string;
  /** The key that does the same; empty for none. */
  key: string;
  /** Further words by which it is found. */
  about?: string;
  run(): void;
}

const CONTROLS =
  'button, input, select, textarea, summary, a[href], [role=slider], [role=application], [role=grid]';
/** Controls that choose one of a few, which are found by their own names. */
const CHOICES = 30;

/** Returns the controls of the present screen and of the top bar, by their names and panels. */
export function controls(root: ParentNode): Command[] {
  return [...root.querySelectorAll<HTMLElement>(CONTROLS)].flatMap((control) => {
    const name = nameOf(control);
    const off = control.matches(':disabled, [aria-hidden="true"], [type="file"]');
    if (off || name === '' || control.closest('.palette, [popover], [inert]')) return [];
    if (!control.checkVisibility()) return [];
    const group = control.closest('[role=radiogroup], [role=group], [role=toolbar]');
    const [place, about] = [placeOf(control), `${control.title} ${group?.ariaLabel ?? ''}`];
    const command = { name, place, key: '', about, run: () => reach(control) };
    return control instanceof HTMLSelectElement
      ? [command, ...choices(control, command)]
      : [command];
  });
}

/** Returns the panels of the present screen. */
export function places(root: ParentNode): Command[] {
  return panels(root).flatMap((panel) => {
    const name = panel.ariaLabel ?? '';
    return name === '' ? [] : [{ name, place: 'panel', key: '', run: () => focusPart(panel) }];
  });
}

/** Returns what a select offers, where that is not too much. */
function choices(select: HTMLSelectElement, { name, place }: Command): Command[] {
  if (select.options.length > CHOICES) return [];
  return [...select.options].flatMap((option): Command[] => {
    const text = option.text.trim();
    if (option.disabled || option.selected || text === '') return [];
    const choose = () => {
      select.value = option.value;
      select.dispatchEvent(new Event('change', { bubbles: true }));
    };
    return [{ name: `${name}: ${text}`, place, key: '', about: option.title, run: choose }];
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
  if (control.closest('.message')) return 'notice';
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

/** How far up a command stands: named so, a view or screen of such words, a word of its name, the rest. */
function rank({ name, place, about = '' }: Command, first: string): number {
  const [title, words] = [name.toLowerCase(), about.toLowerCase().split(' ')];
  if (title.startsWith(first)) return 0;
  if (first !== '' && (place === 'view' || place === 'screen') && words.includes(first)) return 1;
  return title.split(/[\s,:]+/).some((word) => word.startsWith(first)) ? 2 : 3;
}

/** Returns those in which every word that was typed occurs, the nearest first. */
export function matching(commands: readonly Command[], typed: string): Command[] {
  const words = typed.toLowerCase().split(/\s+/).filter(Boolean);
  const [first = ''] = words;
  const matches = commands.filter(({ name, place, about = '' }) => {
    const text = `${name} ${place} ${about}`.toLowerCase();
    return words.every((word) => text.includes(word));
  });
  return matches.sort((a, b) => rank(a, first) - rank(b, first));
}
