/** The page of views as an address that holds what the Lab has, too. */

import { LINK_MAX, sessionParameters, settingsOf } from '../../app/lab-link';
import { messages } from '../../app/messages.svelte';
import { app } from '../../app/store.svelte';
import { PANES, writeChoice, type ViewChoice } from '../../parts/views/view-choice';
import { copyText } from '../../ui/export';

/** Copies an address that opens the same views in any browser that reaches the server. */
export async function copyLink(panes: readonly ViewChoice[]): Promise<void> {
  const ofLab = panes.some(({ of }) => of === 'staged' || of === 'live');
  const url = new URL(location.pathname, location.href);
  const parameters: Record<string, string> = {
    screen: 'views',
    ...(ofLab ? await labParameters() : {}),
    ...Object.fromEntries(panes.map((choice, i) => [PANES[i] ?? '', writeChoice(choice)])),
  };
  for (const [key, value] of Object.entries(parameters)) {
    if (value !== '') url.searchParams.set(key, value);
  }
  if (url.href.length > LINK_MAX)
    throw new Error(
      `The link would have ${url.href.length} characters; more than ${LINK_MAX} do not arrive everywhere. Keep what is staged and choose its run here.`,
    );
  try {
    await copyText(url.href);
    messages.info('The link is on the clipboard.');
  } catch {
    messages.info(`This browser does not let the page copy. The link:\n${url.href}`, [], {
      stays: true,
    });
  }
}

async function labParameters(): Promise<Record<string, string>> {
  const { start, draft } = app.session;
  if (!start) throw new Error('There is no session yet.');
  const known = app.catalogue.scenarios.some(({ name }) => name === start.name);
  const set = known ? settingsOf(await app.api.scenario(start.name), start) : null;
  return sessionParameters({ scenario: set ? start.name : start, set: set ?? {}, draft });
}
