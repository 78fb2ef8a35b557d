/** Columns of the running session that views draw, besides those of the scopes. */

import { untrack } from 'svelte';

class LiveColumns {
  private wishes = $state.raw<readonly (readonly string[])[]>([]);

  /** Each once, in the order in which they were first wished for. */
  readonly all = $derived([...new Set(this.wishes.flat())]);

  /** Has columns streamed; returns what ends that. */
  wish(columns: readonly string[]): () => void {
    // Whoever wishes does not depend on what others wish.
    this.wishes = [...untrack(() => this.wishes), columns];
    return () => (this.wishes = untrack(() => this.wishes).filter((each) => each !== columns));
  }
}

export const liveColumns = new LiveColumns();
