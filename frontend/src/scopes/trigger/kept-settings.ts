/** The form of a trigger's settings that a browser has kept. */

import { listOf, oneOf, partOf } from '../../app/storage';

export const CONDITIONS_MAX = 4;
export const CAPTURES_MAX = 100;

/** Shortest and longest capture, s. */
export const LENGTH = [0.005, 10] as const;
/** Longest time from a hit to the next, s. */
export const HOLD_OFF_MAX = 60;

const between = (least: number, most: number) => (value: unknown) =>
  typeof value === 'number' && value >= least && value <= most;

const EDGE = { channel: '', slope: oneOf('rising', 'falling', 'either') };

const FORMS: Record<string, unknown> = {
  mark: {},
  reversal: EDGE,
  level: { ...EDGE, level: 0, hysteresis: 0 },
  window: { channel: '', way: oneOf('leaves', 'enters'), low: 0, high: 0, hysteresis: 0 },
};
const CONDITIONS = Object.entries(FORMS).map(([kind, form]) =>
  listOf({ kind: oneOf(kind), ...(form as object) }),
);

function conditions(value: unknown): boolean {
  if (!Array.isArray(value) || value.length === 0 || value.length > CONDITIONS_MAX) return false;
  return value.every((each) => CONDITIONS.some((test) => test([each])));
}

export const KEPT_FORM = partOf({
  conditions,
  join: oneOf('and', 'or'),
  length: between(...LENGTH),
  before: between(0, 1),
  holdOff: between(0, HOLD_OFF_MAX),
  mode: oneOf('auto', 'normal', 'single'),
  most: between(1, CAPTURES_MAX),
});
