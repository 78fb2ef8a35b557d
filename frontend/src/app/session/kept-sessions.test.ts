import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { Scenario } from '../api/types';
import {
  forget,
  type GivenPath,
  keptSessions,
  pathName,
  recall,
  remember,
  rememberDraft,
  withPath,
} from './kept-sessions';

const scenario = {
  name: 'circle',
  plant: { x: {}, y: {} },
  variants: { A: { controller: {} } },
  trajectory: { kind: 'circle' },
} as unknown as Scenario;
const own = { base: scenario, scenario, paths: [], speed: 2 };

beforeEach(() => {
  const kept = new Map<string, string>();
  vi.stubGlobal('localStorage', {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, text: string) => kept.set(key, text),
    removeItem: (key: string) => kept.delete(key),
  });
});

afterEach(() => vi.unstubAllGlobals());

it('keeps what-if changes with their session, whichever was open last', () => {
  remember({ id: 'first', ...own });
  rememberDraft('first', { seed: 7 });
  remember({ id: 'second', ...own });
  expect(keptSessions()).toEqual(['second', 'first']);
  expect(recall('first')).toMatchObject({ draft: { seed: 7 }, speed: 2 });
  expect(recall('second')).toMatchObject({ draft: {} });
  forget('first');
  expect(recall('first')).toBeNull();
});

it('keeps the last few sessions only', () => {
  for (let i = 0; i < 12; i++) remember({ id: `s${i}`, ...own });
  expect(keptSessions()).toHaveLength(8);
  expect(recall('s3')).toBeNull();
  expect(recall('s11')).not.toBeNull();
});

const whole = JSON.stringify({ base: scenario, scenario, paths: [], speed: 1 });

it('recalls a whole session', () => {
  localStorage.setItem('motionlab.session.gone', whole);
  expect(recall('gone')).not.toBeNull();
});

it.each([
  '5',
  '{"base":5}',
  '{"scenario":{}}',
  whole.replace('"paths":[]', '"paths":[null]'),
  whole.replace('"controller":{}', '"controller":null'),
  whole.replace('"speed":1', '"speed":"1"'),
])('does without a session kept as %s', (text) => {
  localStorage.setItem('motionlab.session.gone', text);
  expect(recall('gone')).toBeNull();
});

const circle = { kind: 'circle', radius: 0.015 };
const star = { kind: 'path', points: [[0, 0]], laps: 1 };
const namedPath = (name: string, table = star): GivenPath => ({ name, table });

describe('the name of the path', () => {
  it('is none where the scenario has its own', () => {
    expect(pathName(circle, circle, [namedPath('my-star')])).toBe('');
    expect(pathName({ ...circle, radius: 0.02 }, circle, [])).toBe('');
  });

  it('is the saved name, whatever defaults the server added', () => {
    expect(pathName({ ...star, dwell: 0 }, circle, [namedPath('my-star')])).toBe('my-star');
    expect(pathName({ ...star, laps: 3 }, circle, [namedPath('my-star')])).toBe('my-star, edited');
  });

  it('is "drawn path" without a name, or where it came from elsewhere', () => {
    expect(pathName(star, circle, [namedPath('')])).toBe('drawn path');
    expect(pathName(star, circle, [])).toBe('drawn path');
  });

  it('is that of the one that runs, after another was tried', () => {
    const other = { ...star, points: [[1, 1]] };
    const paths = withPath([namedPath('my-star')], namedPath('other', other));
    expect(pathName(star, circle, paths)).toBe('my-star');
    expect(pathName(other, circle, paths)).toBe('other');
  });
});
