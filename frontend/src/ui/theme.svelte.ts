import { MediaQuery } from 'svelte/reactivity';

export type Theme = 'light' | 'dark';

const KEY = 'motionlab.theme';

/** The colour theme: the system's, until the user chooses. */
class ThemeChoice {
  private readonly system = new MediaQuery('(prefers-color-scheme: dark)');
  private chosen = $state<Theme | null>(null);

  constructor() {
    const kept = document.documentElement.dataset.theme;
    if (kept === 'light' || kept === 'dark') this.chosen = kept;
  }

  get current(): Theme {
    return this.chosen ?? (this.system.current ? 'dark' : 'light');
  }

  toggle(): void {
    const next: Theme = this.current === 'dark' ? 'light' : 'dark';
    this.chosen = next;
    document.documentElement.dataset.theme = next;
    // Plain text, as index.html reads it before any script of the page has run.
    try {
      localStorage.setItem(KEY, next);
    } catch {
      // Forbidden: the choice lasts until the page is left.
    }
  }
}

export const theme = new ThemeChoice();
