/** Math channels that the server has checked: their units, what they read, and how they are computed. */

import { SvelteMap } from 'svelte/reactivity';
import { ApiError, type Api } from '../api/client';
import type { Answer, Operation } from '../api/operations';
import { errorText } from '../error-text';

export type Checked = Answer<Operation<'post', '/expressions/check'>>[number];

/** Whose channels they read: a run's, or those of variants. */
export type Whose = { run: string } | { variants: readonly string[] };

/** Most of one request. */
const MOST = 32;
/** A request to a busy or unreachable server is repeated this much later, ms. */
const AGAIN = 3000;

const keyOf = (whose: Whose, column: string) => `${JSON.stringify(whose)} ${column}`;

export class Expressions {
  private readonly known = new SvelteMap<string, Checked>();
  private readonly requested: Record<string, boolean> = {};

  constructor(private readonly api: Api) {}

  /** What is known of a math channel; undefined while the server has not answered. */
  of(whose: Whose, column: string): Checked | undefined {
    return this.known.get(keyOf(whose, column));
  }

  /** Asks the server about math channels that are not known yet. */
  want(whose: Whose, columns: readonly string[]): void {
    if ('variants' in whose && whose.variants.length === 0) return;
    const fresh = columns.filter((column) => !this.requested[keyOf(whose, column)]);
    for (let i = 0; i < fresh.length; i += MOST) void this.get(whose, fresh.slice(i, i + MOST));
  }

  /** Checks a math channel that is being written. */
  async check(whose: Whose, column: string): Promise<Checked> {
    const known = this.of(whose, column);
    if (known) return known;
    try {
      await this.ask(whose, [column]);
    } catch (error) {
      return refused(column, error);
    }
    return this.of(whose, column) as Checked;
  }

  private async get(whose: Whose, columns: readonly string[]): Promise<void> {
    for (const column of columns) this.requested[keyOf(whose, column)] = true;
    try {
      await this.ask(whose, columns);
    } catch (error) {
      if (error instanceof ApiError && error.transient) {
        setTimeout(() => void this.get(whose, columns), AGAIN);
        return;
      }
      for (const column of columns) this.known.set(keyOf(whose, column), refused(column, error));
    }
  }

  private async ask(whose: Whose, columns: readonly string[]): Promise<void> {
    const body = { columns, ...whose };
    const answers = await this.api.json('post', '/expressions/check', { body });
    for (const each of answers) this.known.set(keyOf(whose, each.column), each);
  }
}

/** Why it could not be asked stands in for what is wrong with it. */
function refused(column: string, error: unknown): Checked {
  const problem = { message: errorText(error), start: 0, end: 0 };
  return { column, name: '', unit: '', channels: [], steps: [], problem };
}
