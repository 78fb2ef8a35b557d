/** The current screen, kept in the address for reload and the browser's back. */

import { fromAddress } from './storage';

/** The menu. */
export const SCREENS = [
  { screen: 'lab', title: 'Lab' },
  { screen: 'trajectories', title: 'Trajectories' },
  { screen: 'runs', title: 'Runs' },
  { screen: 'identify', title: 'Identify' },
  { screen: 'tune', title: 'Tune' },
  { screen: 'sweep', title: 'Sweep' },
  { screen: 'motor', title: 'Motor' },
  { screen: 'paper', title: 'Paper' },
  { screen: 'drive', title: 'Drive' },
] as const;

export type Screen = (typeof SCREENS)[number]['screen'];

class ScreenChoice {
  current = $state<Screen>(addressed());
  /** Counts up when the address has another history entry: what a screen reads there may differ. */
  visits = $state(0);
  /** Whether the server has the documentation: not every installation does. */
  documented = $state(true);

  /** Shows a screen, with what its address says besides. */
  go(screen: Screen, parameters: Record<string, string> = {}): void {
    const more = Object.entries(parameters);
    if (screen === this.current && more.length === 0) return;
    const url = new URL(location.href);
    for (const [key, value] of [['screen', screen] as const, ...more]) {
      url.searchParams.set(key, value);
    }
    history.pushState(null, '', url);
    this.current = screen;
    this.visits += 1;
  }

  get title(): string {
    return SCREENS.find(({ screen }) => screen === this.current)?.title ?? '';
  }

  /** Its page of the documentation; null where the server has none. */
  get help(): string | null {
    return this.documented ? `/help/${this.current}.html` : null;
  }

  /** Follows a link without loading the page anew, unless it is to open elsewhere. */
  follow(event: MouseEvent, screen: Screen, parameters?: Record<string, string>): void {
    if (event.ctrlKey || event.metaKey || event.shiftKey || event.button !== 0) return;
    event.preventDefault();
    this.go(screen, parameters);
  }

  /** Reads the address, after the browser's back or forward. */
  read(): void {
    this.current = addressed();
    this.visits += 1;
  }
}

function addressed(): Screen {
  return SCREENS.find(({ screen }) => screen === fromAddress('screen'))?.screen ?? 'lab';
}

export const screen = new ScreenChoice();
