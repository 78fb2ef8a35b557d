import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import type { DriveStatus } from '../../../app/api/types';
import { type Asked, keepSequence, keptSequence, runText, whyNot } from './drive-rules';

function situation(status: Partial<DriveStatus>, rest: Partial<Asked> = {}): Asked {
  const whole = { state: 'holding', holder: 'me', problem: '', fault: null, ...status };
  return { status: whole as DriveStatus, silent: '', held: true, moving: '', ...rest };
}

test('runs only while this browser has control and the drives hold their position', () => {
  expect(whyNot(situation({}))).toBe('');
  expect(whyNot(situation({ state: 'ready' }))).toBe('Arm the drives first.');
  expect(whyNot(situation({ state: 'stopping' }))).toBe('The drives are stopping.');
  expect(whyNot(situation({}, { held: false }))).toBe('me controls the drives.');
  expect(whyNot(situation({ holder: null }, { held: false }))).toBe(
    'Take control of the drives first.',
  );
  expect(whyNot(situation({}, { moving: 'A' }))).toBe('A moves. STOP ends it.');
});

test('says what is wrong with the drives', () => {
  const fault = { name: 'link lost' } as DriveStatus['fault'];
  expect(whyNot(situation({ state: 'fault', fault }))).toBe('Fault: link lost. Reset it first.');
  expect(whyNot(situation({ state: 'offline', problem: 'no answer' }))).toBe(
    'No drives: no answer.',
  );
  expect(whyNot(situation({ state: 'offline' }))).toBe('The drives are not up yet.');
  const free = { state: 'offline', problem: 'no answer', holder: null };
  expect(whyNot(situation(free, { held: false }))).toBe('No drives: no answer.');
  expect(whyNot(situation({}, { silent: 'gone' }))).toBe('No answer from the server: gone');
  expect(whyNot({ ...situation({}), status: null })).toBe('Asking for the drives.');
});

test('names the variants in their order', () => {
  expect(runText(['A', 'B'])).toBe('Run A, then B on the drive');
  expect(runText(['A'])).toBe('Run A on the drive');
});

const kept = new Map<string, string>();

beforeEach(() => {
  kept.clear();
  vi.stubGlobal('sessionStorage', {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => kept.set(key, value),
    removeItem: (key: string) => kept.delete(key),
  });
});

afterEach(() => vi.unstubAllGlobals());

test('a sequence that has begun outlives a reload, until it has ended', () => {
  expect(keptSequence()).toBeNull();
  const sequence = { motions: ['s-1'], left: ['B'], ghosts: ['r-1'] };
  keepSequence(sequence);
  expect(keptSequence()).toEqual(sequence);
  keepSequence(null);
  expect(keptSequence()).toBeNull();
});

test('what has not begun, or is damaged, is no sequence', () => {
  keepSequence({ motions: [], left: ['A', 'B'], ghosts: [] });
  expect(keptSequence()).toBeNull();
  const [key] = [...kept.keys()];
  for (const text of ['{', '{"motions": "s-1"}', '{"motions": [1], "left": [], "ghosts": []}']) {
    kept.set(key ?? '', text);
    expect(keptSequence()).toBeNull();
  }
});
