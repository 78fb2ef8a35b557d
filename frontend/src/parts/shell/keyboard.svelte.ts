/** Keys of the whole page; each screen adds its own. The help sheet lists the same tables. */

import { app } from '../../app/store.svelte';

export interface KeyTable {
  title: string;
  keys: readonly { keys: string; does: string }[];
}

/** Whether the control that has the focus uses a key itself; it may be of another document. */
export function takesKey({ key, target }: KeyboardEvent): boolean {
  if (target === null || !('matches' in target)) return false;
  const control = target as Element;
  if (control.matches('input:not([type=range], [type=checkbox]), select, textarea')) return true;
  if (key === 'Enter') return control.matches('a[href], button, summary');
  // A link does nothing on space.
  return key === ' ' && control.matches('button, summary, input[type=checkbox]');
}

/** Keys that act on the motor once, however long they are held. */
const ONCE: ReadonlySet<string> = new Set([' ', 'a', 'l', 'r', 'u', 'w']);

/** Handles a key of the whole page by its action; fields and buttons keep the keys that are theirs. */
export function onKey(event: KeyboardEvent, actions: Record<string, () => void>): void {
  if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
  const dialog = document.querySelector<HTMLDialogElement>('dialog[open]');
  // Esc is STOP over a question about torque, which closes by itself.
  if (dialog?.dataset.esc === 'stop') {
    if (event.key === 'Escape') void app.stop();
    return;
  }
  if (dialog) {
    if (event.key === 'Escape' && !dialog.matches(':modal')) dialog.close();
    return;
  }
  if (event.key === 'Escape') {
    // A menu closes by itself.
    if (!document.querySelector(':popover-open')) void app.stop();
    return;
  }
  if (takesKey(event)) return;
  const action = actions[event.key];
  if (!action) return;
  event.preventDefault();
  if (!(event.repeat && ONCE.has(event.key))) action();
}

/** Keys of the screen that is shown. */
class ScreenKeys {
  /** For the help sheet; null while the screen has none. */
  table = $state.raw<KeyTable | null>(null);
  actions: Record<string, () => void> = {};

  /** Takes the keys of a screen; returns what takes them back. */
  take(table: KeyTable, actions: Record<string, () => void>): () => void {
    this.table = table;
    this.actions = actions;
    return () => {
      this.table = null;
      this.actions = {};
    };
  }
}

export const screenKeys = new ScreenKeys();
