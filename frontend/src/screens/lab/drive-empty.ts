/** What the Lab says of a motion on drives of which there are no curves yet. */

import type { SessionInfo } from '../../app/api/types';

export function driveEmptyText(variant: string, state: SessionInfo['state'] | undefined): string {
  return state === 'playing'
    ? `${variant} moves to its start on the drive; curves begin there.`
    : `${variant} ended on the drive before its start.`;
}
