/** Variants that run one after the other, as a tab keeps them over a reload. */

import { listOf, parsed } from '../../../app/storage';

export interface Sequence {
  /** Sessions of the motions that have begun; the last may still move. */
  motions: readonly string[];
  /** Variants that have not begun. */
  left: readonly string[];
  /** Runs that lie behind the present one. */
  ghosts: readonly string[];
}

const KEY = 'motionlab.drive-runs';
const FORM = { motions: listOf(''), left: listOf(''), ghosts: listOf('') };

/** Returns the sequence that a reload has interrupted; null where none had begun. */
export function keptSequence(): Sequence | null {
  const kept = parsed<Sequence | null>(sessionStorage.getItem(KEY), null, FORM);
  return kept && kept.motions.length > 0 ? kept : null;
}

export function keepSequence(sequence: Sequence | null): void {
  if (sequence) sessionStorage.setItem(KEY, JSON.stringify(sequence));
  else sessionStorage.removeItem(KEY);
}
