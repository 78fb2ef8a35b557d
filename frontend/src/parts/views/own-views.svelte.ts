/** Views of one's own, of files of the server: asked for once. */

import type { Schemas } from '../../app/api/types';
import { demo } from '../../app/demo/demo-mode';
import { app } from '../../app/store.svelte';

export type OwnView = Schemas['ViewEntry'];

class OwnViews {
  list = $state.raw<readonly OwnView[]>([]);
  /** Whether the server has said which there are. */
  known = $state(false);
  private loading = false;

  /** Asks for them, unless that has been done; without an answer there are none until the next time. */
  async load(): Promise<void> {
    if (this.loading || demo) return;
    this.loading = true;
    try {
      const { views } = await app.api.json('get', '/studies', {});
      [this.list, this.known] = [views.filter(({ file }) => file !== ''), true];
    } catch {
      this.loading = false;
    }
  }
}

export const ownViews = new OwnViews();
