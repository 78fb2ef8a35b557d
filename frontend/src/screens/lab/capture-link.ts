/** A capture as an address: the run that it is, opened large, looked at as it is in the Lab. */

import { LINK_MAX } from '../../app/lab-link';
import { messages } from '../../app/messages.svelte';
import type { Axis } from '../../app/api/types';
import { MOST, writeOverlay, type Placed } from '../../parts/overlay/overlay-address';
import { lookOf, rounded } from '../../scopes/look';
import type { TimeView } from '../../scopes/time-view.svelte';
import { isRun } from '../../scopes/trigger/trigger.svelte';
import type { Capture } from '../../scopes/trigger/captures';
import { copyText } from '../../ui/export';

type Looked = TimeView & { readonly subject: string; readonly axis: Axis };

/** Returns the parameters of the address; `overlaid` are runs by the times of the Lab. */
export function captureParameters(view: Looked, capture: Capture, overlaid: readonly Placed[]) {
  const { run, ticks, time, tick } = capture;
  // A run begins at 0 s.
  const start = ticks[0] * view.period;
  const behind = view.trigger.all.filter(
    (each) => view.trigger.overlaid.includes(each.key) && isRun(each.run) && each.run !== run,
  );
  const runs = [
    ...overlaid.map((each) => ({ ...each, offset: rounded(each.offset - start) })),
    // Captures lie behind each other with their triggers at one moment.
    ...behind.map((each) => {
      const before = (each.tick - each.ticks[0]) * view.period;
      return {
        id: each.run,
        offset: rounded((tick - ticks[0]) * view.period - before),
        shown: true,
      };
    }),
  ];
  const { layout } = view;
  return {
    screen: 'runs',
    run,
    large: run,
    overlay: writeOverlay(runs.filter(({ id }) => id !== run).slice(0, MOST)),
    curves: JSON.stringify({
      ...lookOf(view, -start),
      at: rounded((view.cursors.at(-1) ?? time) - start),
      of: [view.subject, view.axis],
      ...layout.parameters,
    }),
  };
}

/** Copies an address, or says why there is none. */
export async function copyAddress(parameters: Record<string, string>, more = ''): Promise<void> {
  const url = new URL(location.pathname, location.href);
  for (const [key, value] of Object.entries(parameters)) {
    if (value !== '') url.searchParams.set(key, value);
  }
  const { href } = url;
  if (href.length > LINK_MAX) {
    messages.error(
      `The link would have ${href.length} characters; more than ${LINK_MAX} do not arrive everywhere. Keep what is staged and share its run, or download the scenario as TOML.`,
    );
    return;
  }
  try {
    await copyText(href);
    messages.info(`The link is on the clipboard.${more}`);
  } catch {
    messages.info(`This browser does not let the page copy.${more} The link:\n${href}`, [], {
      stays: true,
    });
  }
}
