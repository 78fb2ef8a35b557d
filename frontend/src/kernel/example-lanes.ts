/** A small answer to POST /whatif/lanes, for tests. */

import type { Lanes } from './lanes';

/** Two variants, two epochs and two rows of parameters; the numbers count up. */
export function exampleLanes(): Lanes {
  const count = (size: number) => Float64Array.from({ length: size }, (_, i) => i);
  const variant = { label: '', law: 'off', enabled: false, notes: ['as planned'] };
  return {
    module: 'abc',
    result: { scenario: 'example', model: 'abc' },
    how: 'whole',
    period: 0.5,
    ticks: 10,
    first: 0,
    stop: 10,
    epochs: [0, 6],
    tabled: [false, false],
    keys: { inputs: 'i', tables: 't' },
    rows: [['p_ref', 'x']],
    references: { position_reference: 'p_ref' },
    moving: ['x'],
    windows: [
      { start: 2, end: 10, settling_band: 1, holds: {}, variants: { A: variant, B: variant } },
    ],
    segments: [0],
    ratios: ['itae'],
    lanes: count(16),
    state: count(4),
    inputs: count(10),
    tables: new Float64Array(),
  };
}
