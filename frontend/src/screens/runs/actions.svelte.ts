/** The small forms for all selected runs: a tag, a name, a note. */

import type { Run } from '../../app/api/types';
import { runs } from './runs.svelte';

export type Form = 'tag' | 'name' | 'note';
/** Where a form stands: below the list, or at the run that is shown. */
export type Place = 'list' | 'run';

const TAG = /^[a-z0-9][a-z0-9._-]{0,31}$/;
const TAG_RULE =
  'A tag has lower-case letters, digits, . _ and -, begins with a letter or digit, and is at most 32 long.';

class Actions {
  form = $state<Form | null>(null);
  place = $state<Place>('list');
  text = $state('');
  problem = $state('');

  /** Tags of any selected run. */
  readonly tags = $derived([...new Set(runs.selected.flatMap(({ tags }) => tags))]);

  open(form: Form, place: Place = 'list'): void {
    if (runs.selected.length === 0) return;
    this.problem = '';
    this.text = form === 'tag' ? '' : shared(runs.selected.map((run) => run[form]));
    this.form = form;
    this.place = place;
  }

  close(): void {
    this.form = null;
    this.problem = '';
  }

  async send(): Promise<void> {
    const { form, selected } = { form: this.form, selected: runs.selected };
    const text = this.text.trim();
    if (form === 'tag') {
      if (!TAG.test(text)) {
        this.problem = TAG_RULE;
        return;
      }
      await runs.change(selected, ({ tags }) => ({ tags: [...new Set([...tags, text])] }));
    } else if (form === 'name') {
      await runs.change(selected, () => ({ name: text }));
    } else {
      await runs.change(selected, () => ({ note: text }));
    }
    this.close();
  }

  async untag(tag: string): Promise<void> {
    const having = runs.selected.filter(({ tags }) => tags.includes(tag));
    await runs.change(having, ({ tags }: Run) => ({ tags: tags.filter((each) => each !== tag) }));
  }
}

/** What all texts are; empty where they differ. */
function shared(texts: readonly string[]): string {
  const [first = ''] = texts;
  return texts.every((text) => text === first) ? first : '';
}

export const actions = new Actions();
