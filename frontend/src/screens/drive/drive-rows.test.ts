import { describe, expect, it } from 'vitest';
import {
  actionText,
  announced,
  changeText,
  faultCode,
  figuresText,
  figureText,
  headline,
  hex,
  liveText,
  markOf,
  placeText,
  pushText,
  stateText,
  stopText,
  stoText,
  strangers,
} from './drive-rows';
import { exampleDrive, exampleFault, exampleStatus } from './example-status';
import type { Finding, Step } from './commissioning.svelte';

it('puts who answers beside who is expected, where that is known', () => {
  expect(strangers(exampleStatus())).toEqual([]);
  const drives = [0x5001, 0x5002].map((product) =>
    exampleDrive({ answers: { vendor: 0xe0000001, product } }),
  );
  expect(strangers(exampleStatus({ drives })).map(({ same }) => same)).toEqual([true, false]);
  expect(strangers(exampleStatus({ drives }))[1]).toMatchObject({
    expected: '0xE0000001, 0x5001',
    actual: '0xE0000001, 0x5002',
  });
});

it('says what the last stop was, and who gave it', () => {
  const at = new Date(2026, 0, 1, 15, 2, 11).getTime() / 1000;
  expect(stopText({ at, cause: 'STOP', by: 'Ada' })).toBe('STOP (Ada), 15:02:11');
  expect(stopText({ at, cause: 'STOP', by: '' })).toBe('STOP, 15:02:11');
});

describe('the headline', () => {
  it('names the state in words', () => {
    const textOf = (state: string) => headline(exampleStatus({ state })).text;
    expect(textOf('ready')).toBe('Ready to arm');
    expect(textOf('holding')).toBe('Armed, at rest');
    expect(textOf('moving')).toBe('Armed and moving');
    expect(textOf('stopping')).toBe('Stopping');
  });

  it('names the drive, the axis or the link that failed', () => {
    const fault = exampleFault();
    const of = (change: object) =>
      headline(exampleStatus({ state: 'fault', fault: { ...fault, ...change } })).text;
    expect(of({})).toBe('Fault of axis y, no torque');
    expect(of({ subject: 'drive', place: 5 })).toBe('Fault of drive 5, no torque');
    expect(of({ subject: 'link', place: 0 })).toBe('Fault of the link, no torque');
  });

  it('never says that there is no torque beside a drive that has it, or says nothing', () => {
    const fault = exampleFault({ subject: 'link', place: 0 });
    const lost = exampleStatus({ state: 'fault', fault, known: false });
    expect(headline(lost).text).toBe('Fault of the link, state not known');
    const [first = exampleDrive(), ...others] = exampleStatus().drives;
    const drives = [{ ...first, state: 'operation enabled' }, ...others];
    const going = exampleStatus({ state: 'fault', fault: exampleFault(), drives });
    expect(headline(going).text).toBe('Fault of axis y, switching off');
  });

  it('is not ready while STO is active or the exchange is out of phase', () => {
    const drives = exampleStatus().drives.map((drive) => ({ ...drive, sto: true }));
    expect(headline(exampleStatus({ drives })).text).toBe('STO is active, no torque');
    expect(headline(exampleStatus({}, { phase_locked: false })).text).toMatch(/^Waiting/);
  });

  it('is not ready while other drives were commissioned', () => {
    const other_drives = 'serial numbers 1 commissioned, 2 found';
    expect(headline(exampleStatus({ other_drives }))).toMatchObject({
      text: 'Not the drives that were commissioned',
      bad: true,
    });
  });

  it('says what bring-up does, and when there is no link', () => {
    const offline = { state: 'offline', step: 'finding drives' };
    expect(headline(exampleStatus(offline))).toMatchObject({ bad: false, note: 'finding drives' });
    expect(headline(exampleStatus({ ...offline, problem: 'no answer' })).bad).toBe(true);
    const ended = { state: 'offline', step: 'operational' };
    expect(headline(exampleStatus(ended)).note).toBe('restart the server');
  });
});

describe('a drive', () => {
  it('has its state in words, with the code of a fault', () => {
    expect(stateText(exampleDrive())).toBe('ready, no torque');
    expect(stateText(exampleDrive({ state: 'fault', error: 0x2310 }))).toBe(
      'fault 0x2310, latched',
    );
    expect(stateText(exampleDrive({ state: 'unknown' }))).toBe('unknown');
  });

  it('never claims that STO allows torque where it is not reported', () => {
    expect([true, false, null].map((sto) => stoText(exampleDrive({ sto })))).toEqual([
      'STO active',
      'STO allows',
      'not reported',
    ]);
  });
});

describe('a fault', () => {
  it('has its place, its code and its figures', () => {
    const { drives } = exampleStatus();
    expect(placeText(exampleFault(), drives)).toBe('axis y');
    const failed = exampleFault({ subject: 'drive', place: 5, code: 0x1000, error: 0x2310 });
    expect(placeText(failed, drives)).toBe('drive 5, y b');
    expect(faultCode(failed)).toBe('0x2310');
    expect(faultCode(exampleFault())).toBe('0x8611');
    expect(figuresText(exampleFault())).toBe('512 µm, limit 500 µm');
    expect(figuresText(exampleFault({ value: null }))).toBe('');
  });
});

it('writes words of registers', () => expect(hex(0x218)).toBe('0x0218'));

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
