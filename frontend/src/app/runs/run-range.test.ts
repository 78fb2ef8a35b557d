import { expect, it } from 'vitest';
import { nearby, samplesOf, toRead } from './run-range';
import { covers, within } from './seen-curves';

const run = { ticks: 21_000, period: 0.0005, duration: 10.5 };
const whole = { start: 0, step: 0.0055, last: 1910 };

it('a stretch of time is the samples within the run that hold it', () => {
  expect(samplesOf({ from: 0, to: 10.5 }, run)).toEqual({ from: 0, to: 21_000 });
  expect(samplesOf({ from: 1, to: 1.001 }, run)).toEqual({ from: 2000, to: 2003 });
  expect(samplesOf({ from: 11, to: 12 }, run)).toEqual({ from: 20_999, to: 21_000 });
});

it('only what lies within a run can be read', () => {
  expect(within({ from: -3, to: 2 }, run)).toEqual({ from: 0, to: 2 });
  expect(within({ from: 11, to: 12 }, run)).toBeNull();
  expect(covers(whole, { from: 0, to: 10.5 })).toBe(true);
  expect(covers({ ...whole, start: 1 }, { from: 0.9, to: 5 })).toBe(false);
});

it('a part is read where the whole is too coarse, with a margin', () => {
  expect(toRead({ from: 0, to: 10.5 }, [whole], run)).toBeNull();
  expect(toRead({ from: 4, to: 6 }, [whole], run)).toEqual({
    range: { from: 3.5, to: 6.5 },
    points: 3000,
  });
  const part = { start: 3.5, step: 0.001, last: 3000 };
  expect(toRead({ from: 4, to: 6 }, [whole, part], run)).toBeNull();
  expect(toRead({ from: 4, to: 6.2 }, [null, part], run)).toBeNull();
  expect(toRead({ from: 4, to: 4.2 }, [whole, part], run)?.range.from).toBeCloseTo(3.95);
  expect(toRead({ from: 12, to: 14 }, [null], run)).toBeNull();
});

it('a window that moves is read ahead of, before it gets to the end of what is there', () => {
  const part = { start: 3.5, step: 0.001, last: 3000 };
  expect(toRead({ from: 4, to: 6 }, [part], run, { moving: true })).toBeNull();
  expect(toRead({ from: 4.25, to: 6.25 }, [part], run, { moving: true })?.range).toEqual({
    from: 3.75,
    to: 8.25,
  });
  expect(
    toRead({ from: 9, to: 11 }, [{ start: 8, step: 0.001, last: 2500 }], run, { moving: true }),
  ).toBeNull();
});

it('however little is looked at, a sample is the finest there is', () => {
  const ticks = { start: 1, step: 0.0005, last: 100 };
  expect(toRead({ from: 1.01, to: 1.02 }, [ticks], run)).toBeNull();
});

it('what is near is read once: the whole in bins of the pyramid, finer, and on both sides', () => {
  const long = { ticks: 480_000, period: 0.0005, duration: 240 };
  const near = nearby({ from: 10, to: 12 }, long, 8);
  expect(near.map(({ range, points }) => [range.from, range.to, points])).toEqual([
    [0, 240, 30_000],
    [10, 12, 8000],
    [8, 14, 6000],
  ]);
  // However many columns there are, an answer has at most 6 MB.
  for (const { points } of nearby({ from: 10, to: 12 }, long, 128)) {
    expect(points * 8 * 128).toBeLessThanOrEqual(6e6);
  }
});

it('a path is read finer than curves over time', () => {
  const long = { ticks: 480_000, period: 0.0005, duration: 240 };
  const all = { from: 0, to: 240 };
  const scopes = { start: 0, step: 0.2, last: 1200 };
  expect(toRead(all, [scopes], long)).toBeNull();
  expect(toRead(all, [scopes], long, { finer: 4 })).toEqual({ range: all, points: 8000 });
});
