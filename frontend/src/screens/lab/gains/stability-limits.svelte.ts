/** Up to where each gain can grow before its loop turns unstable, asked for once a hand rests. */

import type { Api } from '../../../app/api/client';
import { AXES, type Changes, type Loops, type Scenario } from '../../../app/api/types';
import { gainPath } from './gains';
import { Newest } from '../../../app/latest-wins';

/** So long after the last change, ms. */
const REST = 250;

export interface Question {
  scenario: Scenario;
  set: Changes;
}

export class Limits {
  /** By the path of the gain; nothing for gains without a limit. */
  known = $state.raw<Readonly<Record<string, number>>>({});
  private readonly queue = new Newest<Question>((question) => this.run(question));
  private rest: ReturnType<typeof setTimeout> | null = null;

  constructor(private readonly api: Api) {}

  ask(question: Question): void {
    if (this.rest !== null) clearTimeout(this.rest);
    this.rest = setTimeout(() => this.queue.push(question), REST);
  }

  private async run(question: Question): Promise<void> {
    try {
      this.known = read(await this.api.loop(question));
    } catch {
      this.known = {}; // What was refused is told beside its field.
    }
  }
}

/** Returns the limits of a server's answer by path. */
export function read({ variants }: Loops): Record<string, number> {
  const known: Record<string, number> = {};
  for (const [variant, { axes }] of Object.entries(variants)) {
    for (const axis of AXES) {
      const loop = axes[axis];
      if (loop?.k_p_limit) known[gainPath(variant, axis, 'k_p')] = loop.k_p_limit;
      if (loop?.k_d_limit) known[gainPath(variant, axis, 'k_d')] = loop.k_d_limit;
    }
  }
  return known;
}
