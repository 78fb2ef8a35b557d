/** The five steps of the tour: what they say, what they speak of, and what they do on the page. */

import type { Changes } from '../../app/api/types';
import { screen } from '../../app/screen.svelte';
import type { Target } from './rules';

/** What a step stages for as long as it lasts. */
type Stage = (changes: Changes) => void;

export interface Step extends Target {
  title: string;
  /** Two sentences. */
  text: string;
  /** What *Show me* does, in words. */
  does: string;
  show: (stage: Stage) => void;
  /** Whether it needs a server, which a demo has not. */
  server?: boolean;
}

const LAW = 'variants.B.controller.compensation.law';

export const STEPS: readonly Step[] = [
  {
    title: 'Look',
    text: 'A and B move the same motor along the same path, and the headline says how much less B errs. The plane magnifies the errors; Machine shows which phase pulls and what friction holds against it.',
    screen: 'lab',
    targets: '[aria-label="Result"], [aria-label="Plane"], [aria-label="Second view"]',
    does: 'Sets a cursor at a peak of the error, which the pictures follow',
    show: () => press('k'),
  },
  {
    title: 'Why?',
    text: 'Why? takes the causes of the largest error away, one after the other, and simulates the run each time. It ends with the change that lowers the peak most, to be staged by one button.',
    screen: 'lab',
    targets: '[aria-label="Result"] button',
    does: 'Asks why the error is as large as it is',
    show: () => click('[aria-label="Result"] button'),
  },
  {
    title: 'Break it',
    text: 'Equation (25) of the paper for K, taken as printed, makes B far worse than A, which compensates nothing. Staged, it reaches no motor: the page simulates the whole run anew, and the next step takes it back.',
    screen: 'lab',
    targets: '[aria-label="Result"], [aria-label="Metrics"], [aria-label="B compensation law"]',
    does: 'Stages K as published in controller B',
    show: (stage) => stage({ [LAW]: 'published-k' }),
  },
  {
    title: 'Draw a path',
    text: 'A path is drawn by mouse, touch or numbers, and you see at once where the motor cannot follow it. Stage in Lab runs both controllers along it; Ctrl Z takes back what was drawn.',
    screen: 'trajectories',
    targets: 'main [aria-label="Path"], main [aria-label="Limits"]',
    does: 'Opens Trajectories with a star to drag about',
    show: () => void drawStar(),
  },
  {
    title: 'The drive',
    text: 'The same controllers run a machine over EtherCAT: Drive arms it, watches it, and says why it stopped. A virtual drive stands in for one without hardware.',
    screen: 'drive',
    targets: 'main [aria-label="State"]',
    does: 'Opens Drive',
    show: () => screen.go('drive'),
    server: true,
  },
];

function click(selector: string): void {
  document.querySelector<HTMLElement>(selector)?.click();
}

function press(key: string): void {
  dispatchEvent(new KeyboardEvent('keydown', { key, cancelable: true }));
}

/** Has the editor start from a star, as a hand would; the screen may have to be loaded first. */
async function drawStar(): Promise<void> {
  screen.go('trajectories');
  const select = await appeared<HTMLSelectElement>('#start-from');
  if (!select) return;
  select.value = 'star';
  select.dispatchEvent(new Event('change', { bubbles: true }));
}

/** Waits, a few seconds at most, until there is an element. */
async function appeared<T extends Element>(selector: string): Promise<T | null> {
  for (let i = 0; i < 100; i++) {
    const element = document.querySelector<T>(selector);
    if (element) return element;
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
  return null;
}
