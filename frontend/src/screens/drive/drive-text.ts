/** The drive link in words. */

import type { DriveStatus, FaultNow, OneDrive } from '../../app/api/types';
import { digits } from '../../ui/units';

/** States of CiA 402 as a person reads them. */
const STATES: Record<string, string> = {
  'not ready to switch on': 'starting up, no torque',
  'switch on disabled': 'disabled, no torque',
  'ready to switch on': 'ready, no torque',
  'switched on': 'switched on, no torque',
  'operation enabled': 'torque on',
  'quick stop active': 'quick stop',
  'fault reaction active': 'fault, switching off',
};

const STEPS: Record<string, string> = {
  compiling: 'compiling the loop',
  'finding drives': 'finding drives',
  operational: 'operational',
};

export interface Headline {
  text: string;
  note: string;
  bad: boolean;
}

/** A status word or an error code, as manuals have it. */
export function hex(value: number): string {
  return `0x${value.toString(16).toUpperCase().padStart(4, '0')}`;
}

/** Wall clock of a time in s since 1970. */
export function timeOfDay(seconds: number): string {
  return new Date(1000 * seconds).toLocaleTimeString('en-GB');
}

/** Whether drives have ever answered. */
export function seen(status: DriveStatus): boolean {
  return status.age !== null;
}

export function stateText({ state, error }: OneDrive): string {
  if (state === 'fault') return error === 0 ? 'fault, latched' : `fault ${hex(error)}, latched`;
  return STATES[state] ?? state;
}

export function stoText({ sto }: OneDrive): string {
  if (sto === null) return 'not reported';
  return sto ? 'STO active' : 'STO allows';
}

/** The last stop: what it was, who gave it, and when. */
export function stopText({ at, cause, by }: NonNullable<DriveStatus['stopped']>): string {
  return `${cause}${by === '' ? '' : ` (${by})`}, ${timeOfDay(at)}`;
}

/** Each place of the bus with who is expected and who answers there; empty while that is unknown. */
export function strangers(
  status: DriveStatus,
): { name: string; expected: string; actual: string; same: boolean }[] {
  const text = ({ vendor, product }: { vendor: number; product: number }) =>
    `${hex(vendor)}, ${hex(product)}`;
  return status.drives.flatMap((drive, i) => {
    if (!drive.answers) return [];
    const [expected, actual] = [text(drive), text(drive.answers)];
    const name = `${i + 1} ${drive.axis} ${drive.phase}`;
    return [{ name, expected, actual, same: expected === actual }];
  });
}

/** What a fault concerns: `drive 5, y b`, `axis y`, `the link`. */
export function placeText(fault: FaultNow, drives: readonly OneDrive[]): string {
  if (fault.subject === 'axis') return `axis ${fault.place === 1 ? 'x' : 'y'}`;
  const drive = drives[fault.place - 1];
  if (fault.subject === 'link' || !drive) return 'the link';
  return `drive ${fault.place}, ${drive.axis} ${drive.phase}`;
}

/** The code that a manual lists: the drive's own, or ours. */
export function codeOf({ code, error }: FaultNow): string {
  return hex(error || code);
}

/** The figures of a fault: what was found, and what is allowed. */
export function figuresText({ value, limit, unit }: FaultNow): string {
  if (value === null) return '';
  const figure = `${digits(value)} ${unit}`;
  return limit === null || limit === 0 ? figure : `${figure}, limit ${digits(limit)} ${unit}`;
}

/** The state of the link as one headline, and what it means. */
export function headline(status: DriveStatus): Headline {
  const good = (text: string, note: string) => ({ text, note, bad: false });
  const bad = (text: string, note: string) => ({ text, note, bad: true });
  const { fault, drives, loop } = status;
  switch (status.state) {
    case 'fault': {
      // The loop commands none; only the drives themselves can say that there is none.
      const enabled = drives.some(({ state }) => state === 'operation enabled');
      const torque = !status.known ? 'state not known' : enabled ? 'switching off' : 'no torque';
      if (!fault) return bad(`Fault, ${torque}`, '');
      const last = status.faults[0];
      const place = placeText(fault, drives).replace(/,.*/, '');
      return bad(`Fault of ${place}, ${torque}`, last ? `since ${timeOfDay(last.at)}` : '');
    }
    case 'ready':
      if (drives.some(({ sto }) => sto === true)) {
        return bad('STO is active, no torque', 'release the emergency stop to arm');
      }
      if (status.other_drives !== '') {
        return bad('Not the drives that were commissioned', 'they cannot be armed');
      }
      if (!loop.phase_locked) {
        return good('Waiting for the clock of the drives', 'arming needs the exchange in phase');
      }
      return good('Ready to arm', 'six drives without torque, nothing moves until armed');
    case 'arming':
      return good('Arming', 'the drives switch their torque on');
    case 'holding':
      return good('Armed, at rest', 'torque holds the position');
    case 'moving':
      return good('Armed and moving', 'along the motion of the Lab');
    case 'testing':
      return good('A step has torque', 'a step of commissioning moves the stage');
    case 'stopping':
      return good('Stopping', 'brakes to rest, then switches the torque off');
    default:
      if (status.problem !== '') return bad('No link to the drives', '');
      if (status.step === 'operational') return bad('The loop has ended', 'restart the server');
      return good('Bringing the drives up', STEPS[status.step] ?? status.step);
  }
}
