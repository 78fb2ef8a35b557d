/** The whole state of the Lab as an address. */

import { sessionParameters, settingsOf } from '../../app/lab-link';
import { fromAddress } from '../../app/storage';
import { app } from '../../app/store.svelte';
import { readOverlay } from '../../parts/overlay/overlay-address';
import { lookOf } from '../../scopes/look';
import { isRun } from '../../scopes/trigger/trigger.svelte';
import { captureParameters, copyAddress } from './capture-link';
import { view } from './scopes/view.svelte';

const SET_UP_ONLY = ' The link has the set-up, not the recording: a capture has a link of its own.';

/**
 * Copies an address that opens what is shown in any browser that reaches the server: of a capture, its
 * run; else the Lab as it is set up.
 */
export async function copyLink(): Promise<void> {
  await app.try(async () => {
    const { shown } = view.trigger;
    if (shown && isRun(shown.run)) {
      await copyAddress(captureParameters(view, shown, readOverlay(fromAddress('overlay') ?? '')));
      return;
    }
    await copyAddress(await labParameters(), app.mode === 'live' ? SET_UP_ONLY : '');
  });
}

async function labParameters(): Promise<Record<string, string>> {
  const { start, draft } = app.session;
  if (!start) throw new Error('There is no session yet.');
  const known = app.catalogue.scenarios.some(({ name }) => name === start.name);
  const shipped = known ? await app.api.scenario(start.name) : null;
  const set = shipped && settingsOf(shipped, start);
  const { span, variant, axis } = view;
  return {
    screen: 'lab',
    ...sessionParameters({ scenario: set ? start.name : start, set: set ?? {}, draft }),
    mode: app.mode,
    ...view.layout.parameters,
    look: JSON.stringify({ ...lookOf(view), span, of: [variant, axis] }),
    overlay: fromAddress('overlay') ?? '',
  };
}
