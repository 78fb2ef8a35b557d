/** To the clipboard; a page that may not write there shows the text instead. */

import { messages } from '../../app/messages.svelte';

export async function copied(text: string, what: string): Promise<void> {
  try {
    await navigator.clipboard.writeText(text);
    messages.info(`${what} is on the clipboard.`);
  } catch {
    messages.info(`This browser does not let the page copy. ${what}:\n${text}`, [], {
      stays: true,
    });
  }
}
