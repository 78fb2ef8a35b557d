/** The limits of both axes as a table. */

import type { DriveStatus } from '../../app/api/types';
import { digits, minus } from '../../ui/units';

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
