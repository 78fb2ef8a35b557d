/** The current screen, kept in the address for reload and the browser's back. */

import { fromAddress } from './storage';

/** The menu. */
export const SCREENS = [
  { screen: 'lab', title: 'Lab' },
  { screen: 'trajectories', title: 'Trajectories' },
  { screen: 'identify', title: 'Identify' },
  { screen: 'tune', title: 'Tune' },
  { screen: 'sweep', title: 'Sweep' },
  { screen: 'motor', title: 'Motor' },
  { screen: 'paper', title: 'Paper' },
] as const;

export type Screen = (typeof SCREENS)[number]['screen'];

class ScreenChoice {
  current = $state<Screen>(addressed());

  go(screen: Screen): void {
    if (screen === this.current) return;
    const url = new URL(location.href);
    url.searchParams.set('screen', screen);
    history.pushState(null, '', url);
    this.current = screen;
  }

  get title(): string {
    return SCREENS.find(({ screen }) => screen === this.current)?.title ?? '';
  }

  /** Follows a link without loading the page anew, unless it is to open elsewhere. */
  follow(event: MouseEvent, screen: Screen): void {
    if (event.ctrlKey || event.metaKey || event.shiftKey || event.button !== 0) return;
    event.preventDefault();
    this.go(screen);
  }

  /** Reads the address, after the browser's back or forward. */
  read(): void {
    this.current = addressed();
  }
}

function addressed(): Screen {
  return SCREENS.find(({ screen }) => screen === fromAddress('screen'))?.screen ?? 'lab';
}

export const screen = new ScreenChoice();
