/** Loops of the present and the chosen gains, requested when a control comes to rest. */

import type { Api } from '../../app/api/client';
import type { Axis, Changes, LoopAccuracy, LoopResponse, Scenario } from '../../app/api/types';
import { errorText } from '../../app/error-text';
import { LatestWins } from '../../app/latest-wins';
import type { LoopFigures } from '../../parts/loop/loops.svelte';

/** So long after the last change, ms. */
const REST = 200;

export interface LoopQuestion {
  scenario: Scenario;
  set: Changes;
  variant: string;
  axis: Axis;
  /** What the chosen gains change. */
  chosen: Changes;
}

export interface LookedAt {
  response: LoopResponse;
  accuracy: LoopAccuracy;
  /** null where the law has no linearisation. */
  figures: LoopFigures | null;
}

export class LoopStore {
  present = $state.raw<LookedAt | null>(null);
  /** null while the chosen gains are the present ones. */
  chosen = $state.raw<LookedAt | null>(null);
  axis = $state<Axis>('x');
  problem = $state('');
  /** Whether an answer is on its way. */
  asking = $state(false);
  private last: LoopQuestion | null = null;
  private readonly queue = new LatestWins<LoopQuestion>((question) => this.run(question));
  private rest: ReturnType<typeof setTimeout> | null = null;

  constructor(private readonly api: Api) {}

  ask(question: LoopQuestion): void {
    if (this.rest !== null) clearTimeout(this.rest);
    this.asking = true;
    this.last = question;
    this.rest = setTimeout(() => this.queue.push(question), REST);
  }

  /** Asks once more what was refused, as while all of the server's simulations run. */
  again(): void {
    if (this.last) this.ask(this.last);
  }

  private async run(question: LoopQuestion): Promise<void> {
    const { scenario, set, variant, axis, chosen } = question;
    const other = Object.keys(chosen).length > 0;
    try {
      const [present, candidate] = await Promise.all([
        this.look(scenario, set, variant, axis),
        other ? this.look(scenario, { ...set, ...chosen }, variant, axis) : null,
      ]);
      this.axis = axis;
      this.present = present;
      this.chosen = candidate;
      this.problem = '';
    } catch (error) {
      this.present = this.chosen = null;
      this.problem = errorText(error);
    }
    // A newer request may be on its way.
    if (this.last === question) this.asking = false;
  }

  private async look(
    scenario: Scenario,
    set: Changes,
    variant: string,
    axis: Axis,
  ): Promise<LookedAt> {
    const body = { scenario, set };
    const [response, accuracy, loops] = await Promise.all([
      this.api.response({ ...body, variant, axis }),
      this.api.accuracy({ ...body, variant, axis }),
      this.api.loop(body),
    ]);
    return { response, accuracy, figures: loops.variants[variant]?.axes[axis] ?? null };
  }
}
