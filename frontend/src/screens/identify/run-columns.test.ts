import { describe, expect, it } from 'vitest';
import type { RunDetail } from '../../app/api/types';
import { CURRENTS, forces, positions } from './run-columns';

function run(columns: Record<string, string>): RunDetail {
  return {
    columns: Object.entries(columns).map(([name, unit]) => ({ name, unit, meaning: '' })),
  } as unknown as RunDetail;
}

const values = (options: readonly { value: string }[]) => options.map(({ value }) => value);

const RIG = run({
  'x.position_reference': 'm',
  'M.x.position_measured': 'm',
  'M.x.following_error': 'm',
  'M.y.position_measured': 'm',
  'M.x.force_command': 'N',
  'M.x.friction_estimate': 'N',
  'Pos raw': 'mm',
  Kraft: 'N',
  Temp: '',
});

describe('columns of a run', () => {
  it('are positions of the axis, and the file’s own', () => {
    expect(values(positions(RIG, 'M.x.'))).toEqual(['M.x.position_measured', 'Pos raw']);
  });

  it('are forces that act, not parts of a command', () => {
    expect(values(forces(RIG, 'M.x.'))).toEqual(['M.x.force_command', 'Kraft']);
  });

  it('are three currents, or none', () => {
    const two = { 'M.x.current_a': 'A', 'M.x.current_b': 'A' };
    expect(values(forces(run(two), 'M.x.'))).toEqual([]);
    expect(values(forces(run({ ...two, 'M.x.current_c': 'A' }), 'M.x.'))).toEqual([CURRENTS]);
  });
});
