/** On a phone panels lie below one another: what a button opens may be a screen away. */

import { tick } from 'svelte';

const NARROW = '(max-width: 860px)';

/** Scrolls to the first element of a selector once the page has it, where panels are in one column. */
export async function intoView(selector: string): Promise<void> {
  await tick();
  if (matchMedia(NARROW).matches) document.querySelector(selector)?.scrollIntoView();
}
