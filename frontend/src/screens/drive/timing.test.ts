import { describe, expect, it } from 'vitest';
import { exampleStatus } from './example-status';
import { limitRows, alText, linkRows } from './drive-rows';
import { histogram, realTime, SteadyPhase, timingRows } from './timing';

const loop = (change = {}) => exampleStatus({}, change).loop;

describe('the histogram', () => {
  it('has a bar where cycles were, none where there were none, and marks what is known', () => {
    const { series, marks, x } = histogram(loop());
    expect(series[0]?.y).toEqual([null, 119_990, null, 10]);
    expect(series[0]?.x[1]).toBeCloseTo(6e-6, 12);
    expect(marks.map(({ label }) => label)).toEqual(['p50', 'p99']);
    expect(x.to).toBeCloseTo(16e-6, 12);
  });

  it('is empty before the first cycle', () => {
    const recent = { ...loop().recent, round_trips: [0, 0] };
    const { series, bands } = histogram(loop({ recent }));
    expect([series[0]?.y, bands]).toEqual([[null, null], []]);
  });
});

it('counts late cycles as a share of all', () => {
  const rows = timingRows(loop());
  expect(rows.find(({ name }) => name === 'share of all')?.value).toBe('0.051');
  expect(rows.find(({ name }) => name === 'p99.9')?.value).toBe('–');
});

describe('real time', () => {
  it('is green only with priority and locked memory', () => {
    expect(realTime(loop())).toEqual({
      good: true,
      text: 'SCHED_FIFO 80, memory locked',
      remedy: '',
    });
    const refused = realTime(loop({ priority: 0 }));
    expect(refused).toMatchObject({ good: false, text: 'no SCHED_FIFO, memory locked' });
    expect(refused.remedy).toContain('LimitRTPRIO=80');
    expect(refused.remedy).not.toContain('LimitMEMLOCK');
    expect(realTime(loop({ memory_locked: false })).remedy).toContain('LimitMEMLOCK=infinity');
    expect(realTime(loop({ priority: 0, priority_wanted: 0 })).remedy).toBe('');
    // While it is compiled it has not asked.
    expect(realTime(loop({ priority: 0, memory_locked: false, age: null }))).toEqual({
      good: false,
      text: 'real time not asked for yet',
      remedy: '',
    });
  });
});

describe('the link', () => {
  it('names the state of the application layer', () => {
    expect([8, 4, 0x14, 12, 0].map(alText)).toEqual([
      'OP',
      'SAFEOP',
      'SAFEOP, error',
      'mixed',
      '–',
    ]);
  });

  it('marks what is not as it should be', () => {
    const looks = (change = {}, known = true) =>
      linkRows(exampleStatus({ known }, change)).map(({ look }) => look);
    expect(looks()).not.toContain('bad');
    expect(looks({ working_counter: 5 })).toContain('bad');
    expect(looks({ al_status: 0x14 })).toContain('bad');
    expect(looks({ working_counter: 0 }, false)).not.toContain('bad');
  });
});

it('shows limits with their objects, and those that only the loop has', () => {
  const rows = limitRows(exampleStatus());
  expect(rows.find(({ object }) => object === '6065')).toMatchObject({ values: ['500', '500'] });
  expect(rows.find(({ object }) => object === '607D:01')?.values).toEqual(['−84.5', '−84.5']);
  expect(rows.find(({ name }) => name === 'speed')?.object).toBe('loop');
});

it('counts as in phase after a second without a break, and at once where it was so from the start', () => {
  const steady = new SteadyPhase();
  const locked = (phase_locked: boolean, at: number) =>
    steady.of(exampleStatus({}, { phase_locked }), at).loop.phase_locked;
  expect(locked(true, 0)).toBe(true);
  expect(locked(false, 200)).toBe(false);
  expect(locked(true, 400)).toBe(false);
  expect(locked(false, 1300)).toBe(false);
  expect(locked(true, 1500)).toBe(false);
  expect(locked(true, 2499)).toBe(false);
  expect(locked(true, 2500)).toBe(true);
  expect(locked(true, 2700)).toBe(true);
  expect(locked(false, 2900)).toBe(false);
});
