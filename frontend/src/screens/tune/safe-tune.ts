/** Motions on a machine as rows of a table, and what is proposed next in words. */

import type { SafeTune } from '../../app/api/types';

/** A kept run of a motion. */
export interface MadeRun {
  id: string;
  name: string;
}

type Motion = SafeTune['motions'][number];

export interface MotionRow {
  /** The run; null in a rehearsal. */
  run: MadeRun | null;
  /** What was measured; null of a run that has not been read yet. */
  motion: Motion | null;
  best: boolean;
}

/** Returns the motions of a rehearsal in their order. */
export function rehearsedRows({ motions, best }: SafeTune): MotionRow[] {
  return motions.map((motion, k) => ({ run: null, motion, best: k === best }));
}

/** Returns a row for each run, with what a document has measured of it. */
export function runRows(runs: readonly MadeRun[], document: SafeTune | null): MotionRow[] {
  const motions = document?.motions ?? [];
  return runs.map((run) => {
    const at = motions.findIndex((motion) => motion.run === run.id);
    return { run, motion: motions[at] ?? null, best: at >= 0 && at === document?.best };
  });
}

/** Whether a document is of these runs, in this order. */
export function isOf(runs: readonly MadeRun[], { motions }: SafeTune): boolean {
  return motions.length === runs.length && motions.every(({ run }, k) => run === runs[k]?.id);
}

/** Says of a proposal how it compares with the motions made, and who has to decide. */
export function proposalText({ text, beyond }: NonNullable<SafeTune['proposal']>): string {
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}.${beyond ? ' It moves only if you start it.' : ''}`;
}
