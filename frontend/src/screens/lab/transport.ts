/** Labels of the transport buttons, and why one is disabled. */

import type { SessionInfo } from '../../app/api/types';

export interface Transport {
  /** What space and the one dark button do. */
  play: string;
  /** Whether there are what-if changes that can be left out. */
  asItWas: boolean;
  /** Why not; empty where it can be pressed. */
  noPlay: string;
  noStep: string;
}

const NONE = 'There is no session yet: the server has not answered';

/** Returns it for a session with a number of what-if changes that it does not have. */
export function transport(state: SessionInfo['state'] | undefined, pending: number): Transport {
  const changes = pending === 1 ? '1 change' : `${pending} changes`;
  const stays = state === 'paused' || state === 'finished';
  const ended =
    state === 'stopped'
      ? 'Stopped: Reset first'
      : state === 'stopping'
        ? 'Stopping: wait until the motor is at rest'
        : '';
  const missing = state === undefined ? NONE : ended;
  return {
    play: state === 'playing' ? 'Pause' : stays && pending > 0 ? `Play with ${changes}` : 'Play',
    asItWas: stays && pending > 0,
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
