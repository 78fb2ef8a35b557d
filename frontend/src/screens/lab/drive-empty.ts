/** What the Lab says of a motion on drives of which there are no curves, or no result, yet. */

import type { SessionInfo } from '../../app/api/types';

/** `time` is what has been recorded of the motion, s: nothing on the way to its start. */
export function driveEmptyText(
  variant: string,
  state: SessionInfo['state'] | undefined,
  time: number,
): string {
  if (time > 0) {
    return state === 'playing'
      ? `${variant} moves on the drive: no result yet`
      : `${variant} ended on the drive without a result`;
  }
  return state === 'playing'
    ? `${variant} moves to its start on the drive; curves begin there.`
    : `${variant} ended on the drive before its start.`;
}
