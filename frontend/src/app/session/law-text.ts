/** What is said of a law whose file was saved, or that went back to another version. */

import type { RunEvent } from '../api/types';
import { digits } from '../../ui/units';

type LawEvent = Pick<RunEvent, 'law' | 'reason' | 'version' | 'jump'>;

/** Jumps below that are none, N. */
const NO_JUMP = 5e-4;

/** A problem with the name of the file in place of its path. */
export function problemText(problem: string): string {
  return problem.replace(/^.*?([^/\\]+\.py)(?=:)/, '$1');
}

/** Whether the file was taken, with the jump in force that it made; or why not. */
export function lawText(event: LawEvent): string {
  if (event.reason !== '') return `law ${event.law} not taken: ${problemText(event.reason ?? '')}`;
  return lawMark(event);
}

/** The same beside a mark on the time axis: `law mine, version 2: +0.42 N on x, −0.1 N on y`. */
export function lawMark({ law, reason, version, jump = {} }: LawEvent): string {
  if (reason !== '') return `law ${law} not taken`;
  const jumps = jumpText(jump);
  const which = typeof version === 'number' ? `law ${law}, version ${version}` : `law ${law}`;
  if (jumps !== '') return `${which}: ${jumps}`;
  return typeof version === 'number' ? which : `${which}: a new version`;
}

/** The jump in force of each axis; of several variants, with their letters. */
function jumpText(jump: NonNullable<LawEvent['jump']>): string {
  const variants = Object.entries(jump);
  const texts = variants.map(([variant, axes]) => {
    const jumps = Object.entries(axes).filter(([, force]) => Math.abs(force) >= NO_JUMP);
    const text = jumps.map(([axis, force]) => `${signed(force)} N on ${axis}`).join(', ');
    const letter = variants.length > 1 ? `${variant} ` : '';
    return Object.keys(axes).length === 0 ? '' : `${letter}${text || 'no jump in force'}`;
  });
  return texts.filter((text) => text !== '').join('; ');
}

function signed(force: number): string {
  return `${force > 0 ? '+' : ''}${digits(force, 2)}`;
}
