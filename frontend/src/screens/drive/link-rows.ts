/** Figures of the bus. */

import type { DriveStatus } from '../../app/api/types';
import { digits } from '../../ui/units';

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
