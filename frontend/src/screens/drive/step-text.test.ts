import { describe, expect, it } from 'vitest';
import type { Finding, Step } from './commissioning.svelte';
import { exampleDrive, exampleStatus } from './example-status';
import { announced } from './step-moves';
import { actionText, changeText, liveText, markOf } from './step-text';

function step(change: Partial<Step> = {}): Step {
  return {
    name: 'encoders',
    title: 'Homing',
    task: '',
    state: 'now',
    torque: true,
    finding: null,
    ...change,
  };
}

const finding = (holds: boolean): Finding => ({
  at: 0,
  holds,
  text: '',
  rows: [],
  changes: [],
  run: null,
});

it('names a change with its values and their unit', () => {
  const offset = { path: 'x.offset', now: 0, then: -0.00123456 };
  expect(changeText(offset)).toBe('x.offset 0.0000 mm → −1.2346 mm');
  expect(changeText({ path: 'y.direction', now: 1, then: -1 })).toBe('y.direction 1 → −1');
});

it('asks first where torque is switched on', () => {
  expect(actionText(step())).toBe('Begin…');
  expect(actionText(step({ torque: false }))).toBe('Begin');
  expect(actionText(step({ name: 'drives', torque: false }))).toBe('Check');
});

describe('the mark of a step', () => {
  it('tells done, failed, present and waiting apart', () => {
    const states = [
      step({ state: 'done', finding: finding(true) }),
      step({ finding: finding(false) }),
      step(),
      step({ state: 'waiting' }),
    ];
    expect(states.map(markOf)).toEqual(['✓', '✗', '▸', '']);
  });
});

it('announces what moves, how far, how fast and how strongly', () => {
  expect(announced('homing', exampleStatus()).map(({ text }) => text)).toEqual([
    'x, then y',
    'to both end stops, then to the middle',
    '10 mm/s',
    '3.00 A a phase',
  ]);
  expect(announced('drives', exampleStatus())).toEqual([]);
});

it('shows where both axes are, and the largest current', () => {
  const drives = [exampleDrive({ current: 0.5 }), exampleDrive({ current: -1.25 })];
  expect(liveText(exampleStatus({ drives }))).toBe('x 12.300 mm, y 12.300 mm, up to 1.25 A');
});
