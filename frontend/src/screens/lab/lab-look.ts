/** How the Lab is looked at, in its own address: time range, cursors, readings and capture. */

import { fromAddress } from '../../app/storage';
import { lookOf, readLook, takeLook as takeCurvesLook, type Look } from '../../scopes/look';
import { isRun } from '../../scopes/trigger/trigger.svelte';
import { view } from './scopes/view.svelte';

interface LabLook extends Look {
  span?: unknown;
  of?: unknown;
  /** The run of the capture that is shown. */
  capture?: unknown;
}

/** What the address of the Lab itself has: cursors, time range and capture; empty where all is as usual. */
export function labLook(): string {
  const { shown } = view.trigger;
  const { zoom, cursors, levels, measuring } = lookOf(view);
  const capture = shown && isRun(shown.run) ? shown.run : undefined;
  const text = JSON.stringify({ zoom, cursors, levels, measuring, capture });
  return text === '{}' ? '' : text;
}

/** Takes what the address says of zoom, cursors and readings; what is damaged is left out. */
export function takeLook(): void {
  const look = readLook<LabLook>(fromAddress('look'));
  const { span, of, capture } = look;
  if (typeof span === 'number' && span > 0) view.span = span;
  if (Array.isArray(of) && typeof of[0] === 'string') {
    [view.variant, view.axis] = [of[0], of[1] === 'y' ? 'y' : 'x'];
  }
  takeCurvesLook(view, look);
  if (typeof capture !== 'string' || !/^[\w-]+$/.test(capture)) return;
  view.trigger.open = true;
  const known = view.trigger.all.find(({ run }) => run === capture);
  view.trigger.shownKey = known?.key ?? capture;
}
