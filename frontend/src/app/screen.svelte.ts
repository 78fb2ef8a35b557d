/** Which screen is shown; the address says it, so that a reload or the browser's back finds it. */

import type { Component } from 'svelte';
import { fromAddress } from './storage';

interface Entry {
  screen: string;
  title: string;
  /** Loads what is only needed on that screen; the Lab is there from the start. */
  load?: () => Promise<{ default: Component }>;
}

/** The menu. */
export const SCREENS = [
  { screen: 'lab', title: 'Lab' },
  {
    screen: 'trajectories',
    title: 'Trajectories',
    load: () => import('../screens/trajectories/Trajectories.svelte'),
  },
  { screen: 'identify', title: 'Identify', load: () => import('../screens/identify/Identify.svelte') },
  { screen: 'tune', title: 'Tune', load: () => import('../screens/tune/Tune.svelte') },
  { screen: 'motor', title: 'Motor', load: () => import('../screens/motor/Motor.svelte') },
  { screen: 'paper', title: 'Paper', load: () => import('../screens/paper/Paper.svelte') },
] as const satisfies readonly Entry[];

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

  /** The menu's entry of what is shown. */
  get entry(): Entry | undefined {
    return SCREENS.find(({ screen }) => screen === this.current);
  }

  /** Follows a link without loading the page anew, unless it is to open elsewhere. */
  follow(event: MouseEvent, screen: Screen): void {
    if (event.ctrlKey || event.metaKey || event.shiftKey || event.button !== 0) return;
    event.preventDefault();
    this.go(screen);
  }

  /** Takes what the address says, after the browser's back or forward. */
  read(): void {
    this.current = addressed();
  }
}

function addressed(): Screen {
  return SCREENS.find(({ screen }) => screen === fromAddress('screen'))?.screen ?? 'lab';
}

export const screen = new ScreenChoice();
