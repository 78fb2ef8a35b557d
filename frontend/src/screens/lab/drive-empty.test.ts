import { expect, it } from 'vitest';
import { driveEmptyText } from './drive-empty';

it('says that a motion on drives goes to its start, or ended before it, and names no Play', () => {
  expect(driveEmptyText('A', 'playing')).toBe(
    'A moves to its start on the drive; curves begin there.',
  );
  expect(driveEmptyText('B', 'stopped')).toBe('B ended on the drive before its start.');
});
