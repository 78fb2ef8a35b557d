/** A force shared by laws and machines side by side, and what comes of it. */

import type { MapEntry, MapFit } from '../../../app/api/types';
import { listOf, load, oneOf, save } from '../../../app/storage';
import { app } from '../../../app/store.svelte';
import { InstantForm } from '../../../study/study-form.svelte';
import type { Numbers } from '../quantity-fields';
import { laws, requests, type Law, type Run, type SharingChoice } from './sharing-runs';

const KEPT = 'motor.sharing';
/** Machines side by side: more could not be read. */
export const MOST = 2;

const DEFAULT: SharingChoice = {
  machines: ['new-design'],
  laws: ['least-norm', 'force-per-ampere'],
  belief: 'same',
};

const FORM = { machines: listOf(''), laws: listOf(''), belief: oneOf('same', 'fit') };

class Sharing extends InstantForm<readonly Run[]> {
  choice = $state.raw<SharingChoice>(load(KEPT, DEFAULT, FORM));
  maps = $state.raw<readonly MapEntry[]>([]);
  fits = $state.raw<ReadonlyMap<string, MapFit>>(new Map());
  readonly runs = $derived(this.answer ?? []);

  /** Loads the list of machines and asks for the first answer. */
  async start(): Promise<void> {
    await app.try(async () => {
      this.maps = await app.api.maps();
      const known = this.choice.machines.filter(
        (name) => name === 'nominal' || this.maps.some((map) => map.name === name),
      );
      const chosen = laws().filter((law) => this.choice.laws.includes(law));
      this.choose({
        machines: known.length > 0 ? known : DEFAULT.machines,
        laws: chosen.length > 0 ? chosen : DEFAULT.laws,
      });
    });
  }

  /** Adds or takes away a law; one always stays. */
  toggle(law: Law): void {
    const chosen = laws().filter((one) => this.choice.laws.includes(one) !== (one === law));
    if (chosen.length > 0) this.choose({ laws: chosen });
  }

  choose(changes: Partial<SharingChoice>): void {
    this.choice = { ...this.choice, ...changes };
    save(KEPT, this.choice);
    this.ask();
  }

  protected override async request(): Promise<readonly Run[] | null> {
    const { choice } = this;
    if (choice.belief === 'fit') await this.fit(choice.machines);
    const runs: Run[] = [];
    for (const { machine, law, body } of requests(choice, this.entered as Numbers, this.fits)) {
      runs.push({ machine, law, answer: await app.api.shareForce(body) });
      if (this.superseded) return null;
    }
    return runs;
  }

  /** Fits the analytic map to each machine once. */
  private async fit(machines: readonly string[]): Promise<void> {
    for (const name of machines) {
      if (name === 'nominal' || this.fits.has(name)) continue;
      const fit = await app.api.fitMap(name);
      this.fits = new Map([...this.fits, [name, fit]]);
    }
  }
}

export const sharing = new Sharing('sharing');
