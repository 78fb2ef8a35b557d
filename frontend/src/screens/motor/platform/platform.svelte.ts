/** Which platforms are bent, and what the server finds of them while numbers change. */

import { ApiError, UNREACHABLE } from '../../../app/api/client';
import type { Axis, MapEntry, PlatformDocument } from '../../../app/api/types';
import { choicesOf, served } from '../../../app/fields/fields.svelte';
import { LatestWins } from '../../../app/latest-wins';
import { load, oneOf, recordOf, save } from '../../../app/storage';
import { app } from '../../../app/store.svelte';
import { refusals, type Numbers } from '../quantity-fields';
import { bodyOf, platformFields, valueIn, type Asked } from './platform-fields';

const KEPT = 'motor.platform';
const INITIAL: Asked = { axis: 'y', set: {}, support: 'carriages', map: '' };
const FORM = {
  axis: oneOf('x', 'y'),
  set: recordOf(0),
  support: oneOf(...choicesOf('new.support', served.requests.platform).map(({ value }) => value)),
  map: '',
};
/** Time without another number before the server is asked, ms. */
const PAUSE = 80;

class Platform {
  asked = $state.raw<Asked>(load(KEPT, INITIAL, FORM));
  found = $state.raw<PlatformDocument | null>(null);
  /** Maps that can pull at the platforms. */
  maps = $state.raw<readonly MapEntry[]>([]);
  /** What is wrong, by path; at '' what belongs to no single number. */
  problems = $state.raw<Record<string, string>>({});
  /** Whether `found` answers what the form says. */
  fresh = $state(false);
  private last: string | null = null;
  private timer: ReturnType<typeof setTimeout> | null = null;
  private readonly queue = new LatestWins<object>((body) => this.run(body));

  async start(): Promise<void> {
    this.ask({});
    await app.try(async () => {
      this.maps = await app.api.maps();
    });
  }

  value(path: string): number | null {
    return this.asked.set[path] ?? valueIn(this.found, path);
  }

  take(path: string, value: number): void {
    this.last = path;
    this.ask({ set: { ...this.asked.set, [path]: value } });
  }

  reset(path: string): void {
    const kept = Object.entries(this.asked.set).filter(([key]) => key !== path);
    this.ask({ set: Object.fromEntries(kept) });
  }

  clear(): void {
    this.ask({ set: {} });
  }

  /** Turns to the other platform, whose shapes are others. */
  turn(axis: Axis): void {
    this.ask({ axis, set: {} });
  }

  hold(support: string): void {
    this.ask({ support });
  }

  pull(map: string): void {
    this.ask({ map });
  }

  private ask(change: Partial<Asked> & { set?: Numbers }): void {
    this.asked = { ...this.asked, ...change };
    this.fresh = false;
    this.problems = {};
    save(KEPT, this.asked);
    if (this.timer !== null) clearTimeout(this.timer);
    this.timer = setTimeout(() => this.queue.push(bodyOf(this.asked)), PAUSE);
  }

  private async run(body: object): Promise<void> {
    try {
      this.found = await app.api.platform(body);
      this.problems = {};
      this.fresh = !this.queue.superseded;
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      const { errors, detail } = error.problem;
      this.problems =
        errors.length > 0 && error.status !== UNREACHABLE
          ? refusals(errors, platformFields(), this.last)
          : { '': detail };
    }
  }
}

export const platform = new Platform();
