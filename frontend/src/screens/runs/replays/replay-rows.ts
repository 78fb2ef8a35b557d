/** Runs that were simulated again: how many have moved, and which by how much. */

import type { Replays, RunReplay } from '../../../app/api/types';
import { changeText } from '../../../parts/runs/run-text';
import { digits, pretty } from '../../../ui/units';

type Errors = NonNullable<RunReplay['errors']>;

export interface Changed {
  /** Variant and axis. */
  of: string;
  by: string;
  sides: string;
}

export interface MovedRow {
  id: string;
  name: string;
  /** The largest and the RMS error that changed most; null where none did. */
  largest: Changed | null;
  rms: Changed | null;
  /** Channel and time of the first other sample. */
  first: { channel: string; at: string };
  why: string;
}

const counted = (count: number): string => (count === 1 ? '1 run' : `${count} runs`);

/** Which search a request is of: `all runs`, `runs of tag:rig`. */
export function searchText({ q }: Readonly<Record<string, unknown>>): string {
  return typeof q === 'string' && q !== '' ? `runs of ${q}` : 'all runs';
}

/** How many have moved, in words, and whether that is none. */
export function headlineOf({ runs, identical, moved, not_replayable: refused }: Replays) {
  const count = runs.length;
  if (count === 0) return { text: 'The search has no runs.', same: false };
  if (identical + moved === 0) {
    const none = count === 1 ? 'The run cannot' : `None of the ${count} runs can`;
    return { text: `${none} be simulated again.`, same: false };
  }
  const rest = refused > 0 ? ` ${counted(refused)} cannot be simulated again.` : '';
  if (moved === 0) {
    const are = identical === 1 ? '1 run is' : `${identical} runs are`;
    return { text: `None has moved: ${are} the same to the last bit.${rest}`, same: true };
  }
  const have = moved === 1 ? '1 has' : `${moved} have`;
  return {
    text: `Of ${counted(count)} ${have} moved, ${identical} identical.${rest}`,
    same: false,
  };
}

/** The runs that have moved, the one that moved most first. */
export function movedRows({ runs }: Pick<Replays, 'runs'>): MovedRow[] {
  return runs
    .filter(({ outcome }) => outcome === 'moved')
    .map(({ run, name, errors = [], first, reasons = [] }) => ({
      id: run,
      name,
      largest: mostOf(errors, 'max'),
      rms: mostOf(errors, 'rms'),
      first: {
        channel: first?.channel ?? '',
        at: first ? `at ${digits(first.time, 4)} s` : '',
      },
      why: reasons.map(pretty).join('; '),
    }));
}

/** The runs that were not simulated again, and why. */
export function refusedRows({ runs }: Pick<Replays, 'runs'>) {
  return runs
    .filter(({ outcome }) => outcome === 'not replayable')
    .map(({ run, name, reasons = [] }) => ({ id: run, name, why: reasons.map(pretty).join('; ') }));
}

/** The axis whose error changed most. */
function mostOf(errors: Errors, kind: 'max' | 'rms'): Changed | null {
  const changes = errors.map((error) => {
    const [was, is] = [error[`${kind}_recorded`], error[`${kind}_simulated`]];
    const by = error[`${kind}_change`];
    const size = by === null ? (was === is ? 0 : Infinity) : Math.abs(by);
    return { of: `${error.variant} ${error.axis}`, was, is, by, size };
  });
  const [most] = changes.sort((a, b) => (a.size < b.size ? 1 : -1));
  return most && most.size > 0 ? { of: most.of, ...changeText(most.was, most.is, most.by) } : null;
}
