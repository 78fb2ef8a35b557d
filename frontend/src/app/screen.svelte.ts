/** The current screen, kept in the address for reload and the browser's back. */

import type { StudyKind } from './api/types';
import { fromAddress } from './storage';

/**
 * The menu. A screen is the component `screens/NAME/*Screen.svelte`; the fields of its `studies`
 * are loaded before it.
 */
export const SCREENS = [
  { screen: 'lab', title: 'Lab', studies: [] },
  { screen: 'trajectories', title: 'Trajectories', studies: [] },
  { screen: 'runs', title: 'Runs', studies: [] },
  { screen: 'views', title: 'Views', studies: [] },
  { screen: 'identify', title: 'Identify', studies: ['identify'] },
  { screen: 'tune', title: 'Tune', studies: ['tune', 'safe-tune', 'response'] },
  { screen: 'sweep', title: 'Sweep', studies: ['sweep'] },
  { screen: 'motor', title: 'Motor', studies: ['design', 'map', 'sharing', 'platform'] },
  { screen: 'paper', title: 'Paper', studies: [] },
  { screen: 'drive', title: 'Drive', studies: [] },
] as const satisfies readonly { screen: string; title: string; studies: readonly StudyKind[] }[];

export type Screen = (typeof SCREENS)[number]['screen'];

class ScreenChoice {
  current = $state<Screen>(addressed());
  /** Counts up when the address has another history entry: what a screen reads there may differ. */
  visits = $state(0);
  /** Whether the server has the documentation: not every installation does. */
  documented = $state(true);

  /** Shows a screen, with what its address says besides; '' goes from it. */
  go(screen: Screen, parameters: Record<string, string> = {}): void {
    const more = Object.entries(parameters);
    if (screen === this.current && more.length === 0) return;
    const url = new URL(location.href);
    for (const [key, value] of [['screen', screen] as const, ...more]) {
      if (value === '') url.searchParams.delete(key);
      else url.searchParams.set(key, value);
    }
    history.pushState(null, '', url);
    this.current = screen;
    this.visits += 1;
  }

  get title(): string {
    return this.entry.title;
  }

  /** Studies that the current screen is of. */
  get studies(): readonly StudyKind[] {
    return this.entry.studies;
  }

  private get entry() {
    return SCREENS.find(({ screen }) => screen === this.current) ?? SCREENS[0];
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
