import { describe, expect, it, vi } from 'vitest';
import fixture from '../../../../tests/fixtures/demo-why.json';
import type { Changes, Scenario } from '../api/types';
import { type CauseKind, changesOf, explain, type WhyData, type WhyRun } from './why';

const AXES = ['x', 'y'] as const;

describe('the changes that take a cause away', () => {
  it.each(fixture.cases)('are the server’s', ({ scenario, removed }) => {
    for (const [variant, axes] of Object.entries(removed)) {
      for (const axis of AXES) {
        const own = fixture.causes.map((kind) => [
          kind.id,
          changesOf(kind as CauseKind, scenario as unknown as Scenario, variant, axis),
        ]);
        expect(Object.fromEntries(own)).toEqual(axes[axis]);
      }
    }
  });
});

describe('an explained peak', () => {
  const change = (path: string, value: number) => ({ path, value, copied: '', unless: {} });
  const kind = (id: string, ...changes: ReturnType<typeof change>[]) =>
    ({ id, label: id, meaning: '', changes }) as CauseKind;
  const data: WhyData = {
    reach: 0.2,
    goal: 0.5,
    causes: [
      kind('mild', change('plant.{axis}.a', 0)),
      kind('whole', change('{controller}.b', 0)),
      kind('absent', change('{controller}.c', 0), change('{controller}.none', 0)),
      kind('wild', change('{controller}.d', 0)),
      kind('beyond', change('{controller}.e', 0)),
    ],
  };
  const scenario = {
    name: 'example',
    plant: { x: { a: 1 }, y: { a: 1 } },
    variants: { B: { controller: { b: 1, c: 0, d: 1, e: 1 } } },
  } as unknown as Scenario;

  /** Ticks 100 to 120 of 0.1 s; y errs most at 112 in the window, x at 104 before it. */
  function runOf(change: Partial<WhyRun> = {}): WhyRun {
    const errors = (scale: number) => {
      const [x, y] = [new Float32Array(20).fill(0.25), new Float32Array(20).fill(0.25)];
      [x[4], y[12], y[17]] = [-8 * scale, -4 * scale, 2];
      return { x, y };
    };
    const answer = (set: Changes) => {
      if ('plant.y.a' in set) return errors(0.75);
      if ('variants.B.controller.b' in set) return errors(0);
      if ('variants.B.controller.d' in set) return errors(Number.NaN);
      if ('variants.B.controller.e' in set) return 'it decides the inputs';
      return errors(1);
    };
    return {
      scenario,
      moving: ['x', 'y'],
      first: 100,
      stop: 120,
      window: { start: 110, end: 120 },
      period: 0.1,
      lap: 3,
      errors: vi.fn((cases: readonly Changes[]) => Promise.resolve(cases.map(answer))),
      ...change,
    };
  }
  const request = { scenario, variant: 'B' };

  it('has the share of each cause, the largest first, and says what is left out', async () => {
    const run = runOf();
    const why = await explain(data, request, run);
    expect(why).toMatchObject({ scenario: 'example', variant: 'B', axis: 'y', period: 3 });
    expect(why).toMatchObject({ time: 11.2, peak: 4, window_peak: 4, goal: 2 });
    expect(why.window[0]).toBeCloseTo(11);
    expect(why.window[1]).toBeCloseTo(11.5);
    expect(why.causes.map(({ id, error, share }) => [id, error, share])).toEqual([
      ['whole', 0.25, 0.9375],
      ['mild', 3, 0.25],
      ['wild', null, null],
    ]);
    expect(why.causes[1]?.set).toEqual({ 'plant.y.a': 0 });
    expect(why.absent).toEqual([{ id: 'absent', label: 'absent' }]);
    expect(why.notes).toEqual([
      'Left out: beyond. This page cannot run it: it decides the inputs.',
    ]);
    expect(run.errors).toHaveBeenCalledTimes(2);
  });

  it('is that of the axis and about the time that are asked about', async () => {
    const early = await explain(data, { ...request, time: 10.5 }, runOf());
    expect(early).toMatchObject({ axis: 'x', time: 10.4, peak: 8, window_peak: 0.25 });
    const late = await explain(data, { ...request, axis: 'y', time: 11.8, goal: 1 }, runOf());
    expect(late).toMatchObject({ axis: 'y', time: 11.7, peak: 2, window_peak: 4, goal: 1 });
  });

  it('is refused where there is none', async () => {
    const ask = (more: object, run = runOf()) => explain(data, { ...request, ...more }, run);
    await expect(ask({ axis: 'x' }, runOf({ moving: ['y'] }))).rejects.toThrow('axis: does not');
    await expect(ask({ time: 9 })).rejects.toThrow('time: lies before 10 s');
    await expect(ask({ time: 12 })).rejects.toThrow('time: lies after the end');
    const gone = { x: new Float32Array(20).fill(Number.NaN), y: new Float32Array(20) };
    const errors = () => Promise.resolve([gone]);
    await expect(ask({}, runOf({ errors }))).rejects.toThrow('diverges before that');
  });
});
