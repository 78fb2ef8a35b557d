/** Whose gains hold the position: one controller of the session in the Lab. */

import { app } from '../../app/store.svelte';

class Gains {
  chosen = $state('');

  get letters(): readonly string[] {
    return app.variants;
  }

  get letter(): string {
    return this.letters.includes(this.chosen) ? this.chosen : (this.letters[0] ?? '');
  }

  get text(): string {
    const name = app.session.info?.scenario.name;
    return name === undefined || this.letter === '' ? '' : `${this.letter} of ${name}`;
  }
}

export const gains = new Gains();
