/** What must hold before torque is switched on; the question of arming shows the same. */

import type { DriveStatus } from '../../app/api/types';
import { digits } from '../../ui/units';

export interface Check {
  name: string;
  /** Null where it cannot be known: said, but no obstacle. */
  holds: boolean | null;
  text: string;
}

export interface Situation {
  status: DriveStatus;
  /** Whether this page holds control. */
  held: boolean;
  /** Whose gains hold the position; empty where there are none. */
  gains: string;
  /** Why the server has not answered; empty when it has. */
  silent: string;
  /** How many steps of commissioning are done; absent where that is not known. */
  commissioned?: { done: number; of: number } | undefined;
}

export function checksOf({ status, held, gains, silent, commissioned }: Situation): Check[] {
  return [linkCheck(status, silent), faultCheck(status), stoCheck(status), ...others()];

  function others(): Check[] {
    const holder = status.holder === null ? 'no one has it' : `held by ${status.holder}`;
    return [
      { name: 'control', holds: held, text: held ? 'this browser' : holder },
      { name: 'gains', holds: gains !== '', text: gains || 'the Lab has no session' },
      ...(commissioned ? [commissioningCheck(commissioned, status)] : []),
    ];
  }
}

/** Why arming is not possible now, in a sentence; empty when it is. */
export function obstacle(situation: Situation): string {
  const { state, loop } = situation.status;
  const phase = 'The exchange is not yet in phase with SYNC0.';
  return lasting(situation) || (state === 'ready' && !loop.phase_locked ? phase : '');
}

/** The same but for the phase, which comes back by itself: the question waits for it. */
export function lasting(situation: Situation): string {
  const { status, held } = situation;
  if (['arming', 'holding', 'moving', 'testing', 'stopping'].includes(status.state)) return '';
  if (situation.silent !== '') return 'The server does not answer.';
  if (status.state === 'offline') return 'There is no link to the drives.';
  if (status.state === 'fault') return 'A fault is latched. Reset it first.';
  if (status.other_drives !== '') return 'Other drives were commissioned. Do the steps again.';
  if (stoCheck(status).holds === false) return 'STO is active. Release the emergency stop first.';
  if (!held) return 'Take control first.';
  if (situation.gains === '') return 'The Lab has no session whose gains could hold the position.';
  return '';
}

/** Why a step of commissioning cannot begin, in a sentence; empty when it can. */
export function stepObstacle(situation: Situation, torque: boolean): string {
  const { state } = situation.status;
  if (situation.silent !== '') return 'The server does not answer.';
  if (state === 'offline') return 'There is no link to the drives.';
  if (state === 'fault') return 'A fault is latched. Reset it first.';
  if (state === 'stopping') return 'The drives come to rest.';
  if (state !== 'ready') return 'Steps begin without torque. Disarm first.';
  if (!situation.held) return 'Take control first.';
  return torque ? obstacle(situation) : '';
}

function commissioningCheck(
  { done, of }: { done: number; of: number },
  { other_drives }: DriveStatus,
): Check {
  if (other_drives !== '') return { name: 'commissioning', holds: false, text: 'of other drives' };
  return { name: 'commissioning', holds: done === of || null, text: `${done} of ${of} steps done` };
}

function linkCheck(status: DriveStatus, silent: string): Check {
  const { phase_error, phase_locked, period } = status.loop;
  const error = `${digits(1e6 * Math.abs(phase_error), 2)} µs of ${digits(1e5 * period)}`;
  if (silent !== '') return { name: 'link', holds: false, text: 'the server does not answer' };
  if (status.state === 'offline') return { name: 'link', holds: false, text: 'none' };
  const locked = phase_locked ? 'in phase' : 'not in phase';
  const clocks = status.bus.distributed_clocks;
  const text = clocks ? `operational, ${locked}, ${error}` : 'operational';
  return { name: 'link', holds: phase_locked, text };
}

function faultCheck({ state }: DriveStatus): Check {
  const holds = state !== 'fault';
  return { name: 'faults', holds, text: holds ? 'none' : 'latched' };
}

function stoCheck({ drives }: DriveStatus): Check {
  const count = (which: boolean | null) => drives.filter(({ sto }) => sto === which).length;
  const all = drives.length;
  if (count(true) > 0)
    return { name: 'STO', holds: false, text: `active, ${count(true)} of ${all}` };
  if (count(null) > 0) return { name: 'STO', holds: null, text: 'not reported by the drives' };
  return { name: 'STO', holds: true, text: `allows torque, ${count(false)} of ${all}` };
}
