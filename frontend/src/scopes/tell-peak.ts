/** Says what a peak is, so that it can be read where it is and copied. */

import { messages } from '../app/messages.svelte';
import { channelName } from '../plot/scope-catalog';
import { copyText } from '../ui/copy-text';
import { digits, quantity } from '../ui/units';
import type { Peak } from './peaks';
import type { TimeView } from './time-view.svelte';

export function tellPeak(view: TimeView, peak: Peak | null, way: 1 | -1): void {
  if (!peak) {
    const where = way > 0 ? 'after' : 'before';
    messages.info(`No peak ${where} the cursor that stands out by a tenth of what is visible.`);
    return;
  }
  const { column, time, value } = peak;
  const bare = column.replace(/^A-B\./, 'A.');
  const unit = view.channels.find(({ name }) => name === bare)?.unit ?? '1';
  const read = quantity(value, unit);
  const text = `${column}: ${read.number} ${read.unit} at ${digits(time, 7)} s`;
  // All digits, SI, as other programs read them.
  const exact = `${column}\t${time}\t${value}`;
  const why = view.whyOf?.(peak);
  messages.info(`Peak of ${channelName(column)}, ${text}`, [
    { name: 'Copy', run: () => void copyText(exact) },
    ...(why ? [{ name: 'Why?', run: why }] : []),
  ]);
}
