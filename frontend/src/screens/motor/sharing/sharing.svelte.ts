/** What the Force sharing tab asks and what the server finds. */

import { ApiError } from '../../../app/api/client';
import type { MapEntry, MapFit } from '../../../app/api/types';
import { errorText } from '../../../app/error-text';
import { entryOf, served } from '../../../app/fields/fields.svelte';
import { LatestWins } from '../../../app/latest-wins';
import { listOf, load, oneOf, recordOf, save } from '../../../app/storage';
import { app } from '../../../app/store.svelte';
import { fieldAt, refusals } from '../quantity-fields';
import { LAWS, requests, type Asked, type Law, type Run } from './sharing-runs';

const KEPT = 'motor.sharing';
/** Time without another number before the server is asked, ms. */
const PAUSE = 80;
/** Machines side by side: more could not be read. */
export const MOST = 2;

export const PATHS = ['force', 'current_limit', 'overlap'];

const DEFAULT: Asked = {
  machines: ['new-design'],
  laws: ['least-norm', 'force-per-ampere'],
  belief: 'same',
  set: {},
};

const FORM = {
  machines: listOf(''),
  laws: listOf(''),
  belief: oneOf('same', 'fit'),
  set: recordOf(0),
};

/** What was kept, as far as it is still known. */
function kept(): Asked {
  const found = load(KEPT, DEFAULT, FORM);
  const laws = LAWS.filter((law) => found.laws.includes(law));
  return { ...found, laws: laws.length > 0 ? laws : DEFAULT.laws };
}

export const field = (path: string) => fieldAt('sharing', path);
const fields = () => PATHS.map(field);

class Sharing {
  asked = $state.raw<Asked>(kept());
  runs = $state.raw<readonly Run[]>([]);
  maps = $state.raw<readonly MapEntry[]>([]);
  fits = $state.raw<ReadonlyMap<string, MapFit>>(new Map());
  problems = $state.raw<Record<string, string>>({});
  fresh = $state(false);
  private last: string | null = null;
  private timer: ReturnType<typeof setTimeout> | null = null;
  private readonly queue = new LatestWins<Asked>((asked) => this.run(asked));

  /** Loads the list of machines and asks for the first answer. */
  async start(): Promise<void> {
    await app.try(async () => {
      this.maps = await app.api.maps();
      const known = this.asked.machines.filter(
        (name) => name === 'nominal' || this.maps.some((map) => map.name === name),
      );
      this.ask({ machines: known.length > 0 ? known : DEFAULT.machines });
    });
  }

  /** What a field shows: what was typed, else the default. */
  value(path: string): number {
    return this.asked.set[path] ?? Number(entryOf(path, served.requests.sharing)?.default);
  }

  /** Takes one number. */
  take(path: string, value: number): void {
    this.last = path;
    this.ask({ set: { ...this.asked.set, [path]: value } });
  }

  /** Adds or takes away a law; one always stays. */
  toggle(law: Law): void {
    const laws = LAWS.filter((one) => this.asked.laws.includes(one) !== (one === law));
    if (laws.length > 0) this.ask({ laws });
  }

  ask(changes: Partial<Asked> = {}): void {
    this.asked = { ...this.asked, ...changes };
    this.fresh = false;
    save(KEPT, this.asked);
    if (this.timer !== null) clearTimeout(this.timer);
    this.timer = setTimeout(() => this.queue.push(this.asked), PAUSE);
  }

  private async run(asked: Asked): Promise<void> {
    try {
      if (asked.belief === 'fit') await this.fit(asked.machines);
      const runs: Run[] = [];
      for (const { machine, law, body } of requests(asked, this.fits)) {
        runs.push({ machine, law, found: await app.api.shareForce(body) });
        if (this.queue.superseded) return;
      }
      this.runs = runs;
      this.problems = {};
      this.fresh = true;
    } catch (error) {
      const errors = error instanceof ApiError ? error.problem.errors : [];
      this.problems =
        errors.length > 0 ? refusals(errors, fields(), this.last) : { '': errorText(error) };
    }
  }

  /** Fits the analytic map to each machine once. */
  private async fit(machines: readonly string[]): Promise<void> {
    for (const name of machines) {
      if (name === 'nominal' || this.fits.has(name)) continue;
      const found = await app.api.fitMap(name);
      this.fits = new Map([...this.fits, [name, found]]);
    }
  }
}

export const sharing = new Sharing();
