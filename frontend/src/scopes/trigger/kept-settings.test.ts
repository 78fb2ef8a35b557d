import { expect, it } from 'vitest';
import { KEPT_FORM } from './kept-settings';

const LEVEL = { kind: 'level', channel: 'B.x.thrust', slope: 'either', level: 1, hysteresis: 0 };

it.each([{}, { conditions: [LEVEL, { kind: 'mark' }], join: 'and', length: 0.2, most: 100 }])(
  'takes %j',
  (kept) => {
    expect(KEPT_FORM(kept)).toBe(true);
  },
);

it.each([
  { conditions: 5 },
  { conditions: [] },
  { conditions: [null] },
  { conditions: [{ kind: 'level' }] },
  { conditions: [{ ...LEVEL, kind: 'other' }] },
  { conditions: [{ ...LEVEL, level: null }] },
  { length: 1e9 },
  { length: '0.2' },
  { most: -1 },
  { mode: 5 },
])('drops %j', (kept) => {
  expect(KEPT_FORM(kept)).toBe(false);
});
