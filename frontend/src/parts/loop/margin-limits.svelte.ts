/** The limits that margins must hold, for Tune and for everything that marks them. */

import { served } from '../../app/fields/fields.svelte';
import { load, recordOf } from '../../app/storage';

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
