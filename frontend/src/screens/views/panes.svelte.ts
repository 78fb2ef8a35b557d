/** The panes of the page: kind, source, stretch and channels of each, all in the address. */

import { screen } from '../../app/screen.svelte';
import { fromAddress } from '../../app/storage';
import {
  ofKind,
  PANES,
  readChoice,
  writeChoice,
  type ViewChoice,
} from '../../parts/views/view-choice';

/** A link without a pane opens this one. */
const FIRST: ViewChoice = { kind: 'spectrum', of: 'staged', channels: [], stretch: null };

class Panes {
  list = $state.raw<readonly ViewChoice[]>([FIRST]);

  /** Takes what the address says, which a link or the browser's back may have changed. */
  readAddress(): void {
    const all = PANES.flatMap((key) => readChoice(fromAddress(key)) ?? []);
    this.list = all.length > 0 ? all : [FIRST];
  }

  change(at: number, to: ViewChoice): void {
    this.show(this.list.map((each, i) => (i === at ? to : each)));
  }

  get full(): boolean {
    return this.list.length >= PANES.length;
  }

  /** Puts another pane beside the last: the same source in another view. */
  add(): void {
    const [last = FIRST] = this.list.slice(-1);
    const other = ofKind(last, last.kind === 'spectrum' ? 'xy' : 'spectrum');
    this.show([...this.list, other].slice(0, PANES.length));
  }

  close(at: number): void {
    this.show(this.list.filter((_, i) => i !== at));
  }

  swap(): void {
    this.show([...this.list].reverse());
  }

  private show(list: readonly ViewChoice[]): void {
    this.list = list;
    const texts = PANES.map((key, i) => {
      const choice = list[i];
      return [key, choice ? writeChoice(choice) : ''];
    });
    screen.go('views', Object.fromEntries(texts) as Record<string, string>);
  }
}

export const panes = new Panes();
