/** Which controller's numbers are at hand; of the others the Lab has one line each. */

import { load, save } from '../../../app/storage';
import { app } from '../../../app/store.svelte';

const KEY = 'controller';

class OpenController {
  private chosen = $state(load(KEY, ''));

  readonly shown = $derived(app.variants.slice(0, 2));
  readonly variant = $derived(
    this.shown.includes(this.chosen) ? this.chosen : (this.shown.at(-1) ?? ''),
  );

  choose(variant: string): void {
    this.chosen = variant;
    save(KEY, variant);
  }
}

export const openController = new OpenController();
