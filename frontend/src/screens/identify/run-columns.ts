/** Which columns of a run can be a position or a force. */

import type { RunDetail } from '../../app/api/types';

/** The thrust of three currents, by a force map. */
export const CURRENTS = 'currents';

const LENGTHS = /^(m|cm|mm|[uµμ]m|nm)$/i;
const FORCES = /^(k|m)?n$/i;
const MEASURED = /\.(force_realised|force_command|thrust)$/;
const KNOWN_BY_SIMULATION = /\.(position_reference|following_error|bristle|bristle_estimate)$/;

export interface ColumnOption {
  value: string;
  name: string;
}

/** Columns in a unit of length of one variant and axis, and those with names of their own. */
export function positions(run: RunDetail, prefix: string): ColumnOption[] {
  return run.columns
    .filter(({ unit = '' }) => LENGTHS.test(unit))
    .map(({ name = '' }) => name)
    .filter((name) => belongs(name, prefix) && !KNOWN_BY_SIMULATION.test(name))
    .map((name) => ({ value: name, name }));
}

/** Currents, where all three are there, and columns in a unit of force. */
export function forces(run: RunDetail, prefix: string): ColumnOption[] {
  const names = run.columns.map(({ name = '' }) => name);
  const phases = ['a', 'b', 'c'].every((phase) => names.includes(`${prefix}current_${phase}`));
  const columns = run.columns
    .filter(({ unit = '' }) => FORCES.test(unit))
    .map(({ name = '' }) => name)
    .filter((name) => belongs(name, prefix) && (!CHANNEL.test(name) || MEASURED.test(name)))
    .map((name) => ({ value: name, name }));
  return phases ? [{ value: CURRENTS, name: 'currents, by the force map' }, ...columns] : columns;
}

const CHANNEL = /^([A-Z]\.)?[xy]\.\w+$/;

function belongs(name: string, prefix: string): boolean {
  return name.startsWith(prefix) || !CHANNEL.test(name);
}
