import { expect, test } from 'vitest';
import type { DriveStatus } from '../../../app/api/types';
import { runText, whyNot, type Asked } from './why-not';

function asked(status: Partial<DriveStatus>, rest: Partial<Asked> = {}): Asked {
  const whole = { state: 'holding', holder: 'me', problem: '', fault: null, ...status };
  return { status: whole as DriveStatus, silent: '', held: true, moving: '', ...rest };
}

test('runs only while this browser has control and the drives hold their position', () => {
  expect(whyNot(asked({}))).toBe('');
  expect(whyNot(asked({ state: 'ready' }))).toBe('Arm the drives first.');
  expect(whyNot(asked({ state: 'stopping' }))).toBe('The drives are stopping.');
  expect(whyNot(asked({}, { held: false }))).toBe('me controls the drives.');
  expect(whyNot(asked({ holder: null }, { held: false }))).toBe(
    'Take control of the drives first.',
  );
  expect(whyNot(asked({}, { moving: 'A' }))).toBe('A moves. STOP ends it.');
});

test('says what is wrong with the drives', () => {
  const fault = { name: 'link lost' } as DriveStatus['fault'];
  expect(whyNot(asked({ state: 'fault', fault }))).toBe('Fault: link lost. Reset it first.');
  expect(whyNot(asked({ state: 'offline', problem: 'no answer' }))).toBe('No drives: no answer.');
  expect(whyNot(asked({ state: 'offline' }))).toBe('The drives are not up yet.');
  const free = { state: 'offline', problem: 'no answer', holder: null };
  expect(whyNot(asked(free, { held: false }))).toBe('No drives: no answer.');
  expect(whyNot(asked({}, { silent: 'gone' }))).toBe('No answer from the server: gone');
  expect(whyNot({ ...asked({}), status: null })).toBe('Asking for the drives.');
});

test('names the variants in their order', () => {
  expect(runText(['A', 'B'])).toBe('Run A, then B on the drive');
  expect(runText(['A'])).toBe('Run A on the drive');
});
