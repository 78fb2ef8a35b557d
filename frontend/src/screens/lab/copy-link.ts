/** The whole state of the Lab as an address, and back. */

import { LINK_MAX, sessionParameters, settingsOf } from '../../app/lab-link';
import { messages } from '../../app/messages.svelte';
import { fromAddress, parsed, setAddress } from '../../app/storage';
import { app } from '../../app/store.svelte';
import { copyText } from '../../ui/export';
import { STATISTICS } from '../../scopes/statistics';
import { view } from './scopes/view.svelte';

interface Look {
  zoom?: unknown;
  cursors?: unknown;
  statistic?: unknown;
  span?: unknown;
  of?: unknown;
}

/** Copies an address that opens the Lab as it is in any browser that reaches the server. */
export async function copyLink(): Promise<void> {
  await app.try(async () => {
    const link = await labLink();
    if (link.length > LINK_MAX) {
      messages.error(
        `The link would have ${link.length} characters; more than ${LINK_MAX} do not arrive everywhere. Keep what is staged and share its run, or download the scenario as TOML.`,
      );
      return;
    }
    try {
      await copyText(link);
      messages.info('The link is on the clipboard.');
    } catch {
      messages.info(`This browser does not let the page copy. The link:\n${link}`, [], {
        stays: true,
      });
    }
  });
}

async function labLink(): Promise<string> {
  const { start, draft } = app.session;
  if (!start) throw new Error('There is no session yet.');
  const known = app.catalogue.scenarios.some(({ name }) => name === start.name);
  const shipped = known ? await app.api.scenario(start.name) : null;
  const set = shipped && settingsOf(shipped, start);
  const url = new URL(location.pathname, location.href);
  const parameters = {
    screen: 'lab',
    ...sessionParameters({ scenario: set ? start.name : start, set: set ?? {}, draft }),
    mode: app.mode,
    scopes: view.layout.changed ? view.layout.text : '',
    layout: view.layout.name,
    look: JSON.stringify(look()),
    overlay: fromAddress('overlay') ?? '',
  };
  for (const [key, value] of Object.entries(parameters)) {
    if (value !== '') url.searchParams.set(key, value);
  }
  return url.href;
}

function look(): Look {
  const { zoom, cursors, statistic, span, variant, axis } = view;
  return { zoom: zoom && [zoom.from, zoom.to], cursors, statistic, span, of: [variant, axis] };
}

/** Takes what the address says of zoom, cursors and readings; what is damaged is left out. */
export function takeLook(): void {
  const { statistic, span, of, zoom, cursors } = parsed<Look>(fromAddress('look'), {});
  setAddress({ look: '' });
  const known = STATISTICS.find(({ id }) => id === statistic);
  if (known) view.statistic = known.id;
  if (typeof span === 'number' && span > 0) view.span = span;
  if (Array.isArray(of) && typeof of[0] === 'string') {
    [view.variant, view.axis] = [of[0], of[1] === 'y' ? 'y' : 'x'];
  }
  const [from, to] = times(zoom);
  if (from !== undefined && to !== undefined && to > from) view.zoom = { from, to };
  view.cursors = times(cursors);
}

/** Two times at most. */
function times(value: unknown): number[] {
  return Array.isArray(value) ? value.filter(Number.isFinite).slice(0, 2).map(Number) : [];
}
