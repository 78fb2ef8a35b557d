import { expect, it } from 'vitest';
import { driveEmptyText } from './drive-empty';

it('says that a motion on drives goes to its start, or ended before it, and names no Play', () => {
  expect(driveEmptyText('A', 'playing', 0)).toBe(
    'A moves to its start on the drive; curves begin there.',
  );
  expect(driveEmptyText('B', 'stopped', 0)).toBe('B ended on the drive before its start.');
});

it('does not speak of the start once the motion has begun', () => {
  expect(driveEmptyText('A', 'playing', 0.4)).toBe('A moves on the drive: no result yet');
  expect(driveEmptyText('A', 'stopped', 2.193)).toBe('A ended on the drive without a result');
});
