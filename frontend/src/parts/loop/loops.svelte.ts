/** Margins and stability limits of the controllers that are shown: the page's, then the server's. */

import { type Api, ApiError } from '../../app/api/client';
import type { Axis, Changes, Loops, Scenario } from '../../app/api/types';
import { LatestWins } from '../../app/latest-wins';
import type { LoopOfAxis, LoopOfVariant } from '../../kernel/loops';
import { served } from '../../app/fields/fields.svelte';
import { load, recordOf } from '../../app/storage';

/** So long after the server had no room for a request it is repeated, ms. */
const AGAIN = 500;
/** Time between two requests at least, ms: margins are read, and take longer than the curves. */
const SPACING = 33;
/** So long after the last question it is asked, where the page has margins of it already, ms. */
const REST = 200;
/** So long nothing may come before the figures that are shown are marked as older, ms. */
const PATIENCE = 500;

export interface LoopQuestion {
  scenario: Scenario;
  set: Changes;
}

export type LoopFigures = NonNullable<Loops['variants'][string]['axes'][string]>;

/** The figures at one velocity. */
export type LoopAt = LoopFigures['standstill'];

export class LoopMargins {
  /** null before the first answer, and where the last question was refused. */
  known = $state.raw<Readonly<Record<string, LoopOfVariant>> | null>(null);
  /** Whether the figures are older than the controls. */
  asking = $state(false);
  /** Whether figures are shown that have been older than the controls for more than a moment. */
  late = $state(false);
  private readonly queue = new LatestWins<LoopQuestion>((question) => this.run(question));
  private newest: LoopQuestion | null = null;
  /** Whether the page computes them while a control moves. */
  private inPage = false;
  private rest: ReturnType<typeof setTimeout> | undefined;
  private patience: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly api: Pick<Api, 'loop'>) {}

  /**
   * Asks the server: at once, or, where the page computes margins, when the questions stop. One question
   * is on its way, and of those that wait the newest follows.
   */
  ask(question: LoopQuestion): void {
    this.asking = true;
    this.newest = question;
    this.wait();
    clearTimeout(this.rest);
    if (this.inPage) this.rest = setTimeout(() => this.queue.push(question), REST);
    else this.queue.push(question);
  }

  /** Takes what the page has computed; null where it does not. */
  take(loops: Readonly<Record<string, LoopOfVariant>> | null): void {
    this.inPage = loops !== null;
    if (loops) this.show(loops);
  }

  /** Marks what is shown unless something comes soon. */
  private wait(): void {
    this.patience ??= setTimeout(() => (this.late = this.known !== null), PATIENCE);
  }

  private show(loops: Readonly<Record<string, LoopOfVariant>> | null): void {
    this.known = loops;
    this.late = false;
    clearTimeout(this.patience);
    this.patience = undefined;
  }

  /** Returns a loop's figures; null before they are known and where a law has no linearisation. */
  of(variant: string, axis: Axis): LoopOfAxis | null {
    return this.known?.[variant]?.axes[axis] ?? null;
  }

  /** Says why a controller has no figures; empty where it has some or nothing is known yet. */
  reason(variant: string): string {
    return this.known?.[variant]?.note ?? '';
  }

  private async run(question: LoopQuestion): Promise<void> {
    const spaced = new Promise((resolve) => setTimeout(resolve, SPACING));
    try {
      const { variants } = await this.api.loop(question);
      // The page may have shown later ones.
      if (!this.inPage || question === this.newest) this.show(variants);
    } catch (error) {
      // A newer question is on its way; its answer counts.
      if (this.queue.superseded) return;
      if (error instanceof ApiError && error.transient) {
        await new Promise((resolve) => setTimeout(resolve, error.retryAfter ?? AGAIN));
        if (!this.queue.superseded) this.queue.push(question);
        return;
      }
      this.show(null); // The refusal is shown at its field.
    }
    if (!this.queue.superseded) this.asking = false;
    else this.wait();
    await spaced;
  }
}

export type MarginName = 'gain_margin' | 'phase_margin' | 'Ms';

/** Limits in SI; null: left out. */
export type Limits = Readonly<Record<string, number | null>>;

class MarginLimits {
  /** The user's, as the form of Tune keeps them; what is left out is the server's default. */
  private entered = $state.raw<Limits>(limitsOf(load('study.tune', {}, recordOf(null))));

  /** Limits of a search for gains: those of the loop, and the others. */
  readonly all = $derived.by((): Limits => {
    const fallback = served.requests.tune?.['constraints']?.default as Limits | undefined;
    return { ...fallback, ...this.entered };
  });

  of(name: MarginName): number | null {
    return this.all[name] ?? null;
  }

  /** Takes what is entered in the form of Tune. */
  take(entered: Readonly<Record<string, unknown>>): void {
    this.entered = limitsOf(entered);
  }
}

/** Limits among values by dotted path. */
function limitsOf(entered: Readonly<Record<string, unknown>>): Limits {
  const limits = Object.entries(entered).flatMap(([path, value]) =>
    path.startsWith('constraints.') && (value === null || typeof value === 'number')
      ? [[path.slice('constraints.'.length), value] as const]
      : [],
  );
  return Object.fromEntries(limits);
}

export const marginLimits = new MarginLimits();
