/** The limits that margins must hold, for Tune and for everything that marks them. */

import { served } from '../../app/fields/fields.svelte';
import { load, nullOr, partOf, recordOf } from '../../app/storage';

export type MarginName = 'gain_margin' | 'phase_margin' | 'Ms';

/** Limits in SI; null: left out. */
export type Limits = Readonly<Record<string, number | null>>;

class MarginLimits {
  /** The user's; what is left out is the server's default. */
  private entered = $state.raw<Limits>(
    load<{ limits?: Limits }>('tune', {}, partOf({ limits: recordOf(nullOr(0)) })).limits ?? {},
  );

  /** Limits of a search for gains: those of the loop, and the others. */
  readonly all = $derived.by((): Limits => {
    const fallback = served.requests.tune?.['constraints']?.default as Limits | undefined;
    return { ...fallback, ...this.entered };
  });

  of(name: MarginName): number | null {
    return this.all[name] ?? null;
  }

  /** Takes limits, which the form of the search keeps. */
  take(limits: Limits): void {
    this.entered = limits;
  }
}

export const marginLimits = new MarginLimits();
