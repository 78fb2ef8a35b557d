/** What is sized, and what the server finds of it while numbers change. */

import { ApiError, UNREACHABLE } from '../../../app/api/client';
import type { DesignDocument } from '../../../app/api/types';
import { LatestWins } from '../../../app/latest-wins';
import { fromAddress, load, recordOf, save, setAddress } from '../../../app/storage';
import { app } from '../../../app/store.svelte';
import { nested, numberIn, refusals, type Numbers } from '../quantity-fields';
import { dropped, fieldsOf, taken, type Direction } from './sizing-fields';

export type Preset = DesignDocument['preset'];

const KEPT = 'motor.sizing';
const INITIAL = { preset: 'paper', set: {} };
const FORM = { preset: '', set: recordOf(0) };
/** Time without another number before the server is asked, ms. */
const PAUSE = 40;

class Sizing {
  direction = $state<Direction>(
    fromAddress('direction') === 'dimensions' ? 'dimensions' : 'requirements',
  );
  preset = $state<Preset>(load(KEPT, INITIAL, FORM).preset === 'previous' ? 'previous' : 'paper');
  set = $state.raw<Numbers>(load(KEPT, INITIAL, FORM).set);
  found = $state.raw<DesignDocument | null>(null);
  /** What is wrong, by path; at '' what belongs to no single number. */
  problems = $state.raw<Record<string, string>>({});
  /** Whether `found` answers what the form says. */
  fresh = $state(false);
  private last: string | null = null;
  private timer: ReturnType<typeof setTimeout> | null = null;
  private readonly queue = new LatestWins<object>((body) => this.run(body));

  readonly changed = $derived(
    Object.keys(this.set).filter((path) => path.startsWith(`${this.direction}.`)).length,
  );

  /** What a field shows: what was typed, else what holds; without dimensions, the choices. */
  value(path: string): number | null {
    const { found } = this;
    const table = found && { ...found, dimensions: found.dimensions ?? found.requirements };
    return this.set[path] ?? numberIn(table, path);
  }

  take(path: string, value: number): void {
    this.last = path;
    this.ask(taken(this.set, path, value));
  }

  reset(path: string): void {
    this.ask(dropped(this.set, path));
  }

  /** Gives up all changes of this direction. */
  clear(): void {
    const others = ([path]: [string, number]) => !path.startsWith(`${this.direction}.`);
    this.ask(Object.fromEntries(Object.entries(this.set).filter(others)));
  }

  choose(preset: Preset): void {
    this.preset = preset;
    this.ask({});
  }

  turn(direction: Direction): void {
    this.direction = direction;
    setAddress({ direction });
    this.ask(this.set);
  }

  /** Rates the dimensions that sizing found, with the forces, masses and strokes that hold. */
  rate(): void {
    const { found } = this;
    if (!found) return;
    const sized = Object.entries(found.sizing.dimensions).flatMap(([name, value]) =>
      typeof value === 'number' && name !== 'p' && name !== 's'
        ? [[`dimensions.${name}`, value] as const]
        : [],
    );
    this.ask({ ...this.set, ...Object.fromEntries(sized) });
    this.turn('dimensions');
  }

  /** Fills in what the paper does not tell of a design from the one that it does. */
  async borrow(): Promise<void> {
    await app.try(async () => {
      const { dimensions } = await app.api.design({});
      const borrowed = fieldsOf('dimensions').flatMap(({ path }) => {
        const value = numberIn({ dimensions }, path);
        return value !== null && BORROWED.test(path) ? [[path, value] as const] : [];
      });
      this.ask({ ...Object.fromEntries(borrowed), ...this.set });
    });
  }

  ask(set: Numbers = this.set): void {
    this.set = set;
    this.fresh = false;
    save(KEPT, { preset: this.preset, set });
    const own = Object.entries(set).filter(([path]) => path.startsWith(`${this.direction}.`));
    const body = { preset: this.preset, ...nested(Object.fromEntries(own)) };
    if (this.timer !== null) clearTimeout(this.timer);
    this.timer = setTimeout(() => this.queue.push(body), PAUSE);
  }

  private async run(body: object): Promise<void> {
    try {
      this.found = await app.api.design(body);
      this.problems = {};
      this.fresh = !this.queue.superseded;
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      const { errors, detail } = error.problem;
      this.problems =
        errors.length > 0 && error.status !== UNREACHABLE
          ? refusals(errors, fieldsOf(this.direction), this.last)
          : { '': detail };
    }
  }
}

/** What a design needs beyond the paper's choices. */
const BORROWED = /\.(l_m|N|single_phase_force|two_phase_force|mass|stroke)$/;

export const sizing = new Sizing();
