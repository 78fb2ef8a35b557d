/** Whether one run is shown over the whole width, and its curves. */

import { overlay } from '../../../parts/overlay/overlay.svelte';
import { writeOverlay } from '../../../parts/overlay/overlay-address';
import { fromAddress, setAddress } from '../../../app/storage';
import { runs } from '../runs.svelte';
import type { PlayedCurves } from './played-curves.svelte';

class Large {
  /** Its identifier; empty for the list. */
  id = $state(fromAddress('large') ?? '');
  /** What the keys act on. */
  curves: PlayedCurves | null = null;

  /** Shows the first selected run; the others lie behind it. */
  open(): void {
    const [first, ...rest] = runs.selected.filter(
      ({ deleted, state }) => deleted === null && state !== 'recording',
    );
    if (!first) return;
    if (rest.length > 0) overlay.add(rest.map(({ id }) => id));
    this.show(first.id);
  }

  close(): void {
    this.show('');
  }

  /** The address that shows the run as it is. */
  get link(): string {
    const { id, curves } = this;
    const url = new URL(location.pathname, location.href);
    const overlaid = writeOverlay(overlay.list);
    const parameters = { screen: 'runs', run: id, large: id, overlay: overlaid };
    for (const [key, value] of Object.entries({ ...parameters, curves: curves?.lookText ?? '' })) {
      if (value !== '') url.searchParams.set(key, value);
    }
    return url.href;
  }

  readAddress(): void {
    const id = fromAddress('large') ?? '';
    const selected = (fromAddress('run') ?? id).split(',');
    this.id = selected.includes(id) ? id : '';
  }

  private show(id: string): void {
    this.id = id;
    setAddress({ large: id, curves: '' });
  }
}

export const large = new Large();
