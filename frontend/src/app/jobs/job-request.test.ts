import { expect, it } from 'vitest';
import { differing } from './job-request';

const NAMES = { starts: 'starts', window: 'window', limits: 'limits' };
const DEFAULTS = { starts: 4, window: null, limits: { margin: 2 } };

it('names the settings in which a form differs from a request', () => {
  const request = { starts: 4, window: { start: 1, end: 2 }, limits: { margin: 2 }, scenario: 'a' };
  expect(differing(request, request, DEFAULTS, NAMES)).toEqual([]);
  const now = { ...request, window: null, limits: { margin: 3 }, scenario: 'b' };
  expect(differing(request, now, DEFAULTS, NAMES)).toEqual(['window', 'limits']);
});

it('takes what a request leaves out for the default', () => {
  expect(differing({}, DEFAULTS, DEFAULTS, NAMES)).toEqual([]);
  expect(differing({}, { ...DEFAULTS, starts: 2 }, DEFAULTS, NAMES)).toEqual(['starts']);
});
