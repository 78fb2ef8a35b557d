import { describe, expect, it } from 'vitest';
import type { Finding, Step } from './commissioning.svelte';
import { exampleDrive, exampleStatus } from './example-status';
import { announced } from './step-moves';
import { actionText, changeText, figureText, liveText, markOf, pushText } from './step-text';

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

it('names the axis that is still to be pushed, and the address of the virtual drive', () => {
  const status = exampleStatus();
  const elsewhere = { ...status, bus: { ...status.bus, place: '127.0.0.1:35980' } };
  const command = (axis: string) => `--switch 'push={axis="${axis}", force=8, time=0.1}'`;
  expect(pushText(status, [null, null])).toBe(`motionlab vdrive ${command('x')}`);
  expect(pushText(status, [0.02, null])).toBe(`motionlab vdrive ${command('y')}`);
  expect(pushText(elsewhere, [null, 0.02])).toBe(
    `motionlab vdrive --address 127.0.0.1:35980 ${command('x')}`,
  );
});

it('writes minus signs in what a step found, and leaves other hyphens', () => {
  expect(figureText('x: offset wrong by -1.307 mm; y: -2')).toBe(
    'x: offset wrong by −1.307 mm; y: −2',
  );
  expect(figureText('0x5001-3, low-gain, 2019-02-14')).toBe('0x5001-3, low-gain, 2019-02-14');
});
