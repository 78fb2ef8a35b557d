/** The drive link in words. */

import type { DriveStatus, FaultNow, OneDrive } from '../../app/api/types';
import { digits, minus } from '../../ui/units';
import type { Change, Step } from './commissioning.svelte';

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
export function faultCode({ code, error }: FaultNow): string {
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

type Axis = DriveStatus['axes'][number];

export interface LimitRow {
  name: string;
  values: string[];
  unit: string;
  /** Of CiA 402. */
  object: string;
}

export function limitRows({ axes, drives }: DriveStatus): LimitRow[] {
  const row = (name: string, unit: string, object: string, read: (axis: Axis) => string) => ({
    name,
    values: axes.map(read),
    unit,
    object,
  });
  const rated = (axis: string) => drives.find((drive) => drive.axis === axis)?.rated_current ?? 0;
  return [
    row('following error', 'µm', '6065', ({ limits }) => digits(1e6 * limits.following_error)),
    row('for longer than', 'ms', '6066', ({ limits }) => digits(1e3 * limits.following_error_time)),
    row('least position', 'mm', '607D:01', ({ limits }) => fixed(1e3 * limits.position_min)),
    row('largest position', 'mm', '607D:02', ({ limits }) => fixed(1e3 * limits.position_max)),
    row('speed', 'mm/s', 'loop', ({ limits }) => digits(1e3 * limits.velocity_max)),
    row('phase current', 'A', '6073', ({ limits }) => digits(limits.current_max)),
    row('step of current', 'mA', '6071', ({ axis }) => digits(rated(axis))),
  ];
}

function fixed(value: number): string {
  return minus(value.toFixed(1));
}

export interface FigureRow {
  name: string;
  value: string;
  unit?: string;
  look?: 'bad' | 'warn' | 'good' | undefined;
}

/** States of the application layer; drives that differ are or-ed. */
const AL: Record<number, string> = { 1: 'INIT', 2: 'PREOP', 4: 'SAFEOP', 8: 'OP' };
const AL_ERROR = 0x10;

export function alText(status: number): string {
  const name = AL[status & 0x0f];
  const text = name ?? (status === 0 ? '–' : 'mixed');
  return status & AL_ERROR ? `${text}, error` : text;
}

/** Share of a period within which the exchange counts as in phase. */
const IN_PHASE = 0.1;

export function linkRows({ loop, bus, drives, known }: DriveStatus): FigureRow[] {
  const down = !known;
  const all = drives.length;
  const counter = loop.working_counter;
  const limit = IN_PHASE * loop.period;
  return [
    {
      name: `state of ${all} drives`,
      value: down ? 'not known' : alText(loop.al_status),
      look: down || loop.al_status === 8 ? undefined : 'bad',
    },
    {
      name: 'working counter',
      value: down ? '–' : String(counter),
      unit: `of ${all}`,
      look: down || counter === all ? undefined : 'bad',
    },
    { name: 'cycles unanswered', value: String(loop.recent.missed), unit: 'held' },
    bus.distributed_clocks
      ? {
          name: 'phase error to SYNC0',
          value: down ? '–' : digits(1e6 * Math.abs(loop.phase_error), 2),
          unit: `µs of ${digits(1e6 * limit, 2)}`,
          look: down ? undefined : loop.phase_locked ? 'good' : 'warn',
        }
      : { name: 'distributed clocks', value: 'off' },
    { name: 'drive watchdog', value: digits(1e3 * bus.watchdog), unit: 'ms' },
    { name: 'stops after', value: digits(1e3 * bus.loss), unit: 'ms' },
  ];
}

const USUAL = '127.0.0.1:34980'; // of motionlab vdrive without --address

/** A value of a change, with its unit. */
export function valueText(path: string, value: number): string {
  if (path.endsWith('.offset')) return `${minus((1e3 * value).toFixed(4))} mm`;
  return minus(String(value));
}

/** A change in one line: what the file has, and what takes its place. */
export function changeText({ path, now, then }: Change): string {
  return `${path} ${valueText(path, now)} → ${valueText(path, then)}`;
}

/** What the button of the present step says; dots where it asks first. */
export function actionText({ name, torque }: Step): string {
  return torque ? 'Begin…' : name === 'encoders' ? 'Begin' : 'Check';
}

export function markOf({ state, finding }: Step): '✓' | '✗' | '▸' | '' {
  if (state === 'done') return '✓';
  if (finding?.holds === false) return '✗';
  return state === 'now' ? '▸' : '';
}

/** What moves at the moment: positions, and the largest current of a phase. */
export function liveText({ axes, drives }: DriveStatus): string {
  const places = axes.map(
    ({ axis, position }) => `${axis} ${minus((1e3 * position).toFixed(3))} mm`,
  );
  const most = Math.max(...drives.map(({ current }) => Math.abs(current)));
  return `${places.join(', ')}, up to ${digits(most)} A`;
}

/** The command that pushes the mover of a virtual drive along the first axis not yet moved. */
export function pushText({ bus }: DriveStatus, travel: readonly (number | null)[]): string {
  const axis = (travel[0] ?? null) === null ? 'x' : 'y';
  const at = bus.carrier === 'udp' && bus.place !== USUAL ? ` --address ${bus.place}` : '';
  return `motionlab vdrive${at} --switch 'push={axis="${axis}", force=8, time=0.1}'`;
}

/** Figures of a finding as the page writes numbers: the server's have hyphens for minus signs. */
export function figureText(text: string): string {
  return text.replace(/(?<![\w.])-(?=\d)/g, minus);
}

export interface Announced {
  name: 'moves' | 'how far' | 'how fast' | 'how strong';
  text: string;
}

/** Shares of the largest current: of one phase alone, and of a field that draws the mover. */
const ALONE = 0.1;
const DRAW = 0.3;

/** Returns the rows of the question before a step; none for one that is not known here. */
export function announced(step: string, { axes }: DriveStatus): Announced[] {
  const current = (share: number) => {
    const values = axes.map(({ limits }) => digits(share * limits.current_max));
    return `${[...new Set(values)].join(' and ')} A a phase`;
  };
  switch (step) {
    case 'currents':
      return rows('each phase alone may draw the mover', 'within a pole pitch', '', current(ALONE));
    case 'commutation':
      return rows('x, then y', 'a pole pitch up and down', '', current(DRAW));
    case 'homing':
      return rows('x, then y', 'to both end stops, then to the middle', '10 mm/s', current(DRAW));
    case 'hold':
      return rows('x, then y', '2 mm and back', '5 mm/s', `${current(1)} at most, low gains`);
    case 'friction':
      return rows('x and y', 'up to 30 mm and back', 'up to 80 mm/s', `${current(1)} at most`);
    case 'response':
      return rows(
        'x, then y',
        'up to 75 mm about the middle and back',
        'up to 45 mm/s',
        `${current(1)} at most, low gains`,
      );
    default:
      return [];
  }
}

function rows(moves: string, far: string, fast: string, strong: string): Announced[] {
  const all: Announced[] = [
    { name: 'moves', text: moves },
    { name: 'how far', text: far },
    { name: 'how fast', text: fast },
    { name: 'how strong', text: strong },
  ];
  return all.filter(({ text }) => text !== '');
}
