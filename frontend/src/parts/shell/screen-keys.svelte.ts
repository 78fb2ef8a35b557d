/** Keys of a screen that is loaded when it is first shown. */

import type { KeyTable } from './keys';

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
