/** Labels of the transport buttons, and why one is disabled. */

import type { SessionInfo } from '../../app/api/types';

export interface Transport {
  /** What space and the one dark button do. */
  play: string;
  /** The other way to play where there are what-if changes: without them or, taken back, with them. */
  other: string;
  /** Why not; empty where it can be pressed. */
  noPlay: string;
  noStep: string;
}

const NONE = 'There is no session yet: the server has not answered';

/**
 * Returns it for a session with a number of what-if changes that it does not have.
 *
 * @param takenBack whether they were sent and taken back: they are not played again unasked
 */
export function transport(
  state: SessionInfo['state'] | undefined,
  pending: number,
  takenBack = false,
): Transport {
  const changes = pending === 1 ? '1 change' : `${pending} changes`;
  const stays = state === 'paused' || state === 'finished';
  const ended =
    state === 'stopped'
      ? 'Stopped: Reset first'
      : state === 'stopping'
        ? 'Stopping: wait until the motor is at rest'
        : '';
  const withChanges = `Play with ${changes}`;
  const choice = stays && pending > 0;
  const missing = state === undefined ? NONE : ended;
  return {
    play: state === 'playing' ? 'Pause' : choice && !takenBack ? withChanges : 'Play',
    other: !choice ? '' : takenBack ? withChanges : 'Play as it was',
    noPlay: missing,
    noStep:
      missing ||
      (state === 'playing'
        ? 'Playing: Pause first'
        : state === 'finished'
          ? 'Finished: Play or Reset starts again at 0 s'
          : ''),
  };
}
