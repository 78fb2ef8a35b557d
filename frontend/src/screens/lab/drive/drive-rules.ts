/** Why the Lab cannot move the drives. */

import type { DriveStatus } from '../../../app/api/types';
import { listOf, parsed } from '../../../app/storage';

export interface Asked {
  status: DriveStatus | null;
  /** Why the server does not answer; empty when it does. */
  silent: string;
  /** Whether this browser holds control. */
  held: boolean;
  /** The variant that moves; empty while none does. */
  moving: string;
}

/** Returns why the button cannot be pressed; empty where it can. */
export function whyNot({ status, silent, held, moving }: Asked): string {
  if (silent !== '') return `No answer from the server: ${silent}`;
  if (!status) return 'Asking for the drives.';
  if (moving !== '') return `${moving} moves. STOP ends it.`;
  if (status.state === 'offline') {
    return status.problem === '' ? 'The drives are not up yet.' : `No drives: ${status.problem}.`;
  }
  if (!held) {
    return status.holder === null
      ? 'Take control of the drives first.'
      : `${status.holder} controls the drives.`;
  }
  switch (status.state) {
    case 'holding':
      return '';
    case 'fault':
      return `Fault: ${status.fault?.name ?? 'see the Drive screen'}. Reset it first.`;
    case 'testing':
      return 'A step of commissioning goes on.';
    case 'ready':
      return 'Arm the drives first.';
    default:
      return `The drives are ${status.state}.`;
  }
}

/** Returns the label of the button: which variants run, in turn. */
export function runText(variants: readonly string[]): string {
  return `Run ${variants.join(', then ')} on the drive`;
}

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
